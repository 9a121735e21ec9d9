# What every target of slipd shares: warnings, sanitizers, and the two functions that make libraries and modules.
option(SLIPD_WERROR "Treat warnings as errors" OFF)
set(SLIPD_SANITIZE "" CACHE STRING "Sanitizers, as for -fsanitize= (address,undefined or thread)")

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(nlohmann_json 3.11 REQUIRED)

add_library(slipd_flags INTERFACE)
target_compile_options(slipd_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast
  -Wcast-align -Woverloaded-virtual $<$<CXX_COMPILER_ID:Clang>:-Wno-pass-failed> $<$<BOOL:${SLIPD_WERROR}>:-Werror>)
target_include_directories(slipd_flags INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_link_libraries(slipd_flags INTERFACE Threads::Threads)
if(SLIPD_SANITIZE)
  target_compile_options(slipd_flags INTERFACE -fsanitize=${SLIPD_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    -fno-sanitize=null)  # a null pointer ends the program by itself
  set(SLIPD_SANITIZE_LINK -fsanitize=${SLIPD_SANITIZE})
  if(SLIPD_SANITIZE MATCHES address)  # AddressSanitizer's runtime as a library, for programs that are not ours and load libslipd
    set(SLIPD_SANITIZER_RUNTIME libasan.so)
    if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
      set(SLIPD_SANITIZER_RUNTIME libclang_rt.asan-${CMAKE_SYSTEM_PROCESSOR}.so)
    endif()
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=${SLIPD_SANITIZER_RUNTIME}
      OUTPUT_VARIABLE SLIPD_SANITIZER_RUNTIME OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND NOT SLIPD_FUZZ)
      target_compile_definitions(slipd_flags INTERFACE __SANITIZE_ADDRESS__=1)  # as GCC says it
      cmake_path(GET SLIPD_SANITIZER_RUNTIME PARENT_PATH folder)
      list(APPEND SLIPD_SANITIZE_LINK -shared-libsan -Wl,-rpath,${folder})
    endif()
  endif()
  target_link_options(slipd_flags INTERFACE ${SLIPD_SANITIZE_LINK})
endif()

# Limits what a memory fault can do. A stack that was overrun ends the program (stack-protector, stack-clash), and so does a library
# call on a buffer that is too small (FORTIFY_SOURCE). Indirect jumps reach marked targets only (cf-protection on x86, branch
# protection on arm64). Addresses are random (PIE). The linker's tables are read-only (relro, now). vm.hardening checks all of it.
option(SLIPD_HARDEN "Harden the binaries, as packaged" OFF)
if(SLIPD_HARDEN)
  include(CheckPIESupported)
  check_pie_supported()
  target_compile_options(slipd_flags INTERFACE -fstack-protector-strong -fstack-clash-protection -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2
    $<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},x86_64>:-fcf-protection=full>
    $<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},aarch64>:-mbranch-protection=standard>)
  target_link_options(slipd_flags INTERFACE -Wl,-z,relro,-z,now,-z,noexecstack)
endif()

# The preset `coverage` counts the lines that run in the folders below. Everything else is compiled as in the preset dev and comes
# from the same cache. Threads may lose counts, but a line that ran has a count above 0.
option(SLIPD_COVERAGE "Count which lines of core, paper, schema, driver_api, config, drivers and daemon run" OFF)
if(SLIPD_COVERAGE)
  target_link_options(slipd_flags INTERFACE --coverage)
endif()
function(slipd_note_lines target)
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE room)
  if(SLIPD_COVERAGE AND room MATCHES "^(core|paper|schema|driver_api|config|drivers|daemon)(/|$)")
    target_compile_options(${target} PRIVATE --coverage -O1)
    set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)
  endif()
endfunction()

include(SlipdPrecompiled)
if(SLIPD_PRECOMPILE)  # collecting garbage less often saves the compiler time and costs memory, up to 1.5 GB at once
  target_compile_options(slipd_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-expand=200;--param=ggc-min-heapsize=400000>)
endif()

# slipd_optimise_under_sanitizers(): what computes in the folder is optimised there, too. Headers that the compiler has read before were read
# with other options, so they are read anew.
macro(slipd_optimise_under_sanitizers)
  if(SLIPD_SANITIZE)
    add_compile_options(-O1)
    set(SLIPD_PRECOMPILED "")
  endif()
endmacro()

# slipd_library(name SOURCES … LINKS …): one room as a static library.
function(slipd_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC slipd_flags ${ARG_LINKS})
  slipd_use_precompiled(${name})
  slipd_note_lines(${name})
endfunction()

# slipd_loadable(target file component): what the daemon loads at run time, FILE.so in the folder of its modules.
function(slipd_loadable target file component)
  set_target_properties(${target} PROPERTIES
    PREFIX "" OUTPUT_NAME ${file} CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON LIBRARY_OUTPUT_DIRECTORY ${SLIPD_MODULE_DIR})
  install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/slipd COMPONENT ${component})
endfunction()

# slipd_driver(name SOURCES … LINKS …): the loadable module slipd-driver-NAME.so.
function(slipd_driver name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(slipd_driver_${name} MODULE ${ARG_SOURCES})
  target_link_libraries(slipd_driver_${name} PRIVATE slipd_flags ${ARG_LINKS})
  slipd_note_lines(slipd_driver_${name})
  slipd_loadable(slipd_driver_${name} slipd-driver-${name} driver_${name})
endfunction()

# slipd_bridge(name SOURCES … LINKS …): library slipd_bridge_NAME of SOURCES, which tests link, and program slipd-NAME of main.cpp,
# in component bridge_NAME with the example NAME.json in /etc/slipd, the unit slipd-NAME.service.in and completion for the shell. The schema NAME.schema.json is
# embedded as slipd_NAME_schema; a name with - has _ there.
function(slipd_bridge name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  slipd_library(slipd_bridge_${name} SOURCES ${ARG_SOURCES} LINKS slipd_bridge_support ${ARG_LINKS})
  string(REPLACE - _ symbol slipd_${name}_schema)
  slipd_embed(slipd_bridge_${name} ${symbol} ${CMAKE_CURRENT_SOURCE_DIR}/${name}.schema.json)
  add_executable(slipd-${name} main.cpp)
  target_link_libraries(slipd-${name} PRIVATE slipd_bridge_${name})
  target_compile_definitions(slipd-${name} PRIVATE SLIPD_VERSION="${PROJECT_VERSION}")
  install(TARGETS slipd-${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT bridge_${name})
  install(FILES ${name}.json DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/slipd COMPONENT bridge_${name})
  install(FILES ${name}.schema.json DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/slipd COMPONENT bridge_${name})
  configure_file(slipd-${name}.service.in ${PROJECT_BINARY_DIR}/systemd/slipd-${name}.service @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/systemd/slipd-${name}.service DESTINATION lib/systemd/system COMPONENT bridge_${name})
  configure_file(${PROJECT_SOURCE_DIR}/bridges/support/completion.in ${PROJECT_BINARY_DIR}/completion/slipd-${name} @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/completion/slipd-${name} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions
    COMPONENT bridge_${name})
endfunction()

# slipd_profiles(target folder component source): the files *.json of the folder `source` are installed in SLIPD_INSTALLED_PROFILES, which `target`
# knows, share/slipd/<folder>; a build tree has them in <folder> beside bin, as an installation does, and needs no source tree beside it.
function(slipd_profiles target folder component source)
  target_compile_definitions(${target} PRIVATE SLIPD_INSTALLED_PROFILES="${CMAKE_INSTALL_FULL_DATAROOTDIR}/slipd/${folder}")
  file(GLOB profiles CONFIGURE_DEPENDS ${source}/*.json)
  foreach(profile ${profiles})
    cmake_path(GET profile FILENAME file)
    configure_file(${profile} ${PROJECT_BINARY_DIR}/${folder}/${file} COPYONLY)
  endforeach()
  install(FILES ${profiles} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/slipd/${folder} COMPONENT ${component})
endfunction()

# slipd_embed(target symbol file): the file's bytes as `extern const std::string_view symbol` in namespace slipd,
# declared in generated/embedded/<symbol>.hpp.
function(slipd_embed target symbol file)
  set(out ${PROJECT_BINARY_DIR}/generated/embedded/${symbol})
  add_custom_command(OUTPUT ${out}.cpp ${out}.hpp
    COMMAND ${CMAKE_COMMAND} -DINPUT=${file} -DSYMBOL=${symbol} -DOUT=${out} -P ${PROJECT_SOURCE_DIR}/cmake/Embed.cmake
    DEPENDS ${file} ${PROJECT_SOURCE_DIR}/cmake/Embed.cmake VERBATIM)
  target_sources(${target} PRIVATE ${out}.cpp ${out}.hpp)
endfunction()
