# Cross build for 64 bit ARM with Debian's compiler, its programs run by QEMU. tools/arm64 prepares what is needed.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR "qemu-aarch64;-L;/usr/aarch64-linux-gnu")
# Libraries of the other architecture lie in a folder of the build tree, taken out of their packages.
set(sysroot ${CMAKE_CURRENT_LIST_DIR}/../build/arm64-libraries)
set(ENV{PKG_CONFIG_LIBDIR} ${sysroot}/usr/lib/aarch64-linux-gnu/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${sysroot})
set(CMAKE_BUILD_RPATH ${sysroot}/usr/lib/aarch64-linux-gnu)
