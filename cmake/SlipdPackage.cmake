# Debian packages, by `cpack -G DEB` or tools/package. A component of the installation that is not named here is in none.
#   slipd                        daemon, slipctl, sliplab, drivers sim, replay and push, unit, manual, configuration
#   slipd-paper                  the trained methods svd-knn and registered, a module that the daemon loads
#   slipd-driver-NAME            a driver for a bus with what its unit needs to be allowed, if the driver was built
#   slipd-mqtt, slipd-modbus, slipd-ros2, slipd-web  estimates on MQTT, for PLCs, as a ROS 2 node, in a browser
#   slipd-feed, slipd-feed-ros2  frames from networks, and from ROS 2 topics
#   slipd-grip-ros2  grippers of ROS 2, for slipd-grip
#   slipd-camera                 cameras that look at a gel, as sensors
#   slipd-grip                   holds objects by slipd's margin, with a gripper
#   slipd-realtime               a drop-in that allows real-time scheduling
#   python3-slipd                the client for Python
#   libslipd0, libslipd-dev      the client library for C and C++: to run, and to compile with
#   slipd-dev                    headers and CMake files for drivers of one's own
set(slipd_packaging ${PROJECT_SOURCE_DIR}/packaging)

# Who packages is who maintains the packages: -DSLIPD_MAINTAINER="NAME <ADDRESS>", else Debian's own DEBFULLNAME and DEBEMAIL, else a placeholder.
if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(slipd_packager "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
else()
  set(slipd_packager "Unset Packager <packager@example.org>")
endif()
set(SLIPD_MAINTAINER "${slipd_packager}" CACHE STRING "Maintainer of the Debian packages: NAME <ADDRESS>")

# Debian's own papers of a package: copyright and changelog.
execute_process(COMMAND date --utc --rfc-email --date ${SLIPD_RELEASED}T12:00:00Z OUTPUT_VARIABLE slipd_released_at OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
configure_file(${slipd_packaging}/changelog.in ${PROJECT_BINARY_DIR}/changelog @ONLY)
execute_process(COMMAND gzip -9nc ${PROJECT_BINARY_DIR}/changelog OUTPUT_FILE ${PROJECT_BINARY_DIR}/changelog.Debian.gz)
execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md OUTPUT_FILE ${PROJECT_BINARY_DIR}/changelog.gz)
file(READ ${PROJECT_SOURCE_DIR}/LICENSE licence)
string(REGEX REPLACE "^MIT License\n\n[^\n]*\n\n" "" licence "${licence}")
string(REGEX REPLACE "\n\n" "\n.\n" licence "${licence}")
string(STRIP "${licence}" licence)
string(REGEX REPLACE "\n" "\n " SLIPD_LICENCE "${licence}")
configure_file(${slipd_packaging}/copyright.in ${PROJECT_BINARY_DIR}/copyright @ONLY)
function(slipd_papers package component)
  install(FILES ${PROJECT_BINARY_DIR}/copyright ${PROJECT_BINARY_DIR}/changelog.Debian.gz ${PROJECT_BINARY_DIR}/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${component})
endfunction()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${SLIPD_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_SET_DESTDIR ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_OUTPUT_FILE_PREFIX ${PROJECT_BINARY_DIR}/packages)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION electronics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(slipd_same_version "slipd (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")

# slipd_package(group NAME package COMPONENTS … SUMMARY … TEXT … DEPENDS … [RECOMMENDS …] [SECTION …] [SCRIPTS folder])
# folder: of Debian's control files, relative to packaging/
macro(slipd_package group package)
  cmake_parse_arguments(PKG "" "SUMMARY;TEXT;DEPENDS;RECOMMENDS;SECTION;SCRIPTS" "COMPONENTS" ${ARGN})
  string(TOUPPER ${group} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_COMPONENT_GROUP_${upper}_DESCRIPTION "${PKG_SUMMARY}\n${PKG_TEXT}")
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${PKG_SUMMARY}\n${PKG_TEXT}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${PKG_DEPENDS}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS "${PKG_RECOMMENDS}")
  if(PKG_SECTION)
    set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${PKG_SECTION})
  endif()
  if(PKG_SCRIPTS)
    cmake_path(ABSOLUTE_PATH PKG_SCRIPTS BASE_DIRECTORY ${slipd_packaging} OUTPUT_VARIABLE scripts)
    file(GLOB CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA ${scripts}/*)
  endif()
  foreach(component ${PKG_COMPONENTS})
    string(TOUPPER ${component} upper_component)
    set(CPACK_COMPONENT_${upper_component}_GROUP ${group})
    list(APPEND CPACK_COMPONENTS_ALL ${component})
  endforeach()
  list(GET PKG_COMPONENTS 0 first_component)
  slipd_papers(${package} ${first_component})
endmacro()

set(CPACK_COMPONENTS_ALL "")
slipd_package(slipd slipd COMPONENTS slipd slipctl sliplab driver_sim driver_replay driver_push SCRIPTS slipd
  DEPENDS "passwd, systemd | systemd-standalone-sysusers | systemd-sysusers" RECOMMENDS slipd-realtime
  SUMMARY "slip margin of tactile sensors, as a service"
  TEXT "slipd watches a robotic gripper's tactile sensors and says, for every\n\
frame, how far the grasp is from slipping. It answers on a Unix socket\n\
in JSON and speaks on CAN.\n\n\
This package has the daemon, its client slipctl, the offline program\n\
sliplab, and the drivers for simulated and replayed sensors and for those\n\
whose frames a program sends.")
slipd_package(realtime slipd-realtime COMPONENTS realtime SCRIPTS part DEPENDS "${slipd_same_version}"
  SUMMARY "real-time scheduling for slipd"
  TEXT "Allows the service slipd real-time scheduling and locked memory, which\n\
its unit does not ask for by itself.")
set(CPACK_DEBIAN_REALTIME_PACKAGE_ARCHITECTURE all)

slipd_package(paper slipd-paper COMPONENTS paper SCRIPTS part DEPENDS "${slipd_same_version}"
  SUMMARY "trained methods of slipd, svd-knn and registered"
  TEXT "Lets slipd use the methods svd-knn and registered, which compare a\n\
frame with simulated contacts. slipd's other methods do not need it.")

set(slipd_bus_usb "USB devices")
set(slipd_bus_hid "HID devices")
set(slipd_bus_modbus "Modbus devices")
set(slipd_bus_serial "sensors on serial lines")
set(slipd_bus_can "sensors on a CAN bus")
foreach(driver usb hid modbus serial can)
  if(TARGET slipd_driver_${driver})
    slipd_package(driver_${driver} slipd-driver-${driver} COMPONENTS driver_${driver} SCRIPTS part
      DEPENDS "${slipd_same_version}" RECOMMENDS slipd-realtime
      SUMMARY "driver of slipd for ${slipd_bus_${driver}}"
      TEXT "Lets slipd read ${slipd_bus_${driver}}: the driver, and what its\n\
service must be allowed for them, and no more.")
  endif()
endforeach()

# The pages, beside the package's papers.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/slipd COMPONENT slipd
  FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.png")

# For drivers of one's own: what a driver includes, and the one library that it may call.
install(FILES ${PROJECT_SOURCE_DIR}/driver_api/driver.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipd/driver_api COMPONENT dev)
install(FILES ${PROJECT_SOURCE_DIR}/core/frame/frame.hpp ${PROJECT_SOURCE_DIR}/core/frame/layout.hpp
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipd/core/frame COMPONENT dev)
install(FILES ${PROJECT_SOURCE_DIR}/core/contact/skin_base.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipd/core/contact COMPONENT dev)
install(TARGETS slipd_frame ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
include(CMakePackageConfigHelpers)
configure_package_config_file(${slipd_packaging}/slipd-config.cmake.in ${PROJECT_BINARY_DIR}/slipd-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/slipd PATH_VARS CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_INCLUDEDIR)
install(FILES ${PROJECT_SOURCE_DIR}/drivers/skeleton/CMakeLists.txt ${PROJECT_SOURCE_DIR}/drivers/skeleton/skeleton.cpp
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/slipd-dev/examples/skeleton COMPONENT dev)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/slipd-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/slipd-config.cmake ${PROJECT_BINARY_DIR}/slipd-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/slipd COMPONENT dev)
slipd_package(dev slipd-dev COMPONENTS dev SECTION libdevel DEPENDS "nlohmann-json3-dev"
  SUMMARY "headers for drivers of slipd"
  TEXT "What a driver for a sensor of one's own is compiled with: the contract\n\
between slipd and a driver, and CMake files.")

slipd_package(python python3-slipd COMPONENTS python SECTION python DEPENDS "python3 (>= 3.10)"
  SUMMARY "client of slipd for Python"
  TEXT "The slip margin of tactile sensors in Python programs: estimates as\n\
they come, requests, and recordings. Uses python3-numpy for taxels and\n\
python3-xxhash to check recordings if they are installed.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)

slipd_package(lib libslipd0 COMPONENTS lib SECTION libs SCRIPTS libslipd0 DEPENDS ""
  SUMMARY "client library of slipd"
  TEXT "The slip margin of tactile sensors in C and C++ programs: requests and\n\
subscriptions on the socket of slipd, and its board in shared memory.")
slipd_package(libdev libslipd-dev COMPONENTS libdev SECTION libdevel
  DEPENDS "libslipd0 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})"
  SUMMARY "client library of slipd, headers"
  TEXT "What programs that use libslipd are compiled with: headers for C and\n\
C++, pkg-config and CMake files, the manual page, and examples.")

# Programs that carry slipd's estimates elsewhere. libslipd is of this build, which dpkg-shlibdeps must be told.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
# slipd_bridge_package(NAME SECTION … SUMMARY … TEXT …): package slipd-NAME of component bridge_NAME, with a unit and /etc/slipd/NAME.json.
macro(slipd_bridge_package name)
  set(SLIPD_BRIDGE ${name})
  foreach(script conffiles postinst prerm postrm)
    configure_file(${slipd_packaging}/bridge/${script}.in ${PROJECT_BINARY_DIR}/packaging/slipd-${name}/${script} @ONLY)
  endforeach()
  slipd_package(bridge_${name} slipd-${name} COMPONENTS bridge_${name} SCRIPTS ${PROJECT_BINARY_DIR}/packaging/slipd-${name}
    DEPENDS "${slipd_same_version}, libslipd0 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})" ${ARGN})
endmacro()
slipd_bridge_package(mqtt SECTION net
  SUMMARY "slip margin of tactile sensors on MQTT"
  TEXT "Publishes the estimates, states and alerts of slipd to an MQTT broker.\n\
Alerts are kept on disk until a broker has acknowledged them. With it\n\
slipctl fleet shows all grippers of a broker.")
slipd_bridge_package(modbus SECTION net
  SUMMARY "slip margin of tactile sensors for PLCs"
  TEXT "Serves the estimates of slipd as input registers of Modbus TCP.")
if(TARGET slipd-ros2)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/bridges/ros2/slipd_msgs DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/slipd/ros2 COMPONENT bridge_ros2)
  slipd_bridge_package(ros2 SECTION net
    SUMMARY "slip margin of tactile sensors as a ROS 2 node"
    TEXT "Publishes the estimates of slipd on ROS 2 topics by DDS: the margin,\n\
forces, alerts and taxels of each sensor. Needs no ROS on this computer.\n\
Brings the package slipd_msgs for ROS 2 workspaces, and layouts of RViz\n\
and PlotJuggler.")
endif()
if(TARGET slipd-feed)
  slipd_bridge_package(feed SECTION net
    SUMMARY "frames of tactile sensors on networks, for slipd"
    TEXT "Receives the messages of sensors that have a server or send on a\n\
network, by WebSocket and UDP, and hands their frames to slipd. Profiles\n\
describe the messages.")
endif()
if(TARGET slipd-feed-ros2)
  slipd_bridge_package(feed-ros2 SECTION net
    SUMMARY "frames of tactile sensors on ROS 2 topics, for slipd"
    TEXT "Subscribes to ROS 2 topics of point clouds, wrenches and arrays by DDS,\n\
and hands their frames to slipd. Profiles describe the messages. Needs no\n\
ROS on this computer.")
endif()
slipd_bridge_package(grip SECTION electronics
  SUMMARY "holds objects with the least force that keeps the slip margin"
  TEXT "Commands a gripper by the slip margin of slipd: closes until contact,\n\
holds, tightens before the object slips, and opens on command only.\n\
Grippers on Modbus by profiles, others by a program of one's own.")
if(TARGET slipd-grip-ros2)
  slipd_bridge_package(grip-ros2 SECTION electronics
    SUMMARY "grippers of ROS 2, for slipd-grip"
    TEXT "Passes the orders of slipd-grip on to a gripper that a node of ROS 2\n\
drives, as goals of the actions GripperCommand or ParallelGripperCommand,\n\
by DDS. Needs no ROS on this computer.")
endif()
slipd_bridge_package(web SECTION web
  SUMMARY "slip margin of tactile sensors in a browser"
  TEXT "Shows what slipd says as a page: margins, pressure and shear, the last\n\
minute, recordings, and the measured error of its methods. It only reads,\n\
and listens on this computer unless it is told otherwise.")

# Its unit is a template: which cameras there are is an administrator's to say.
if(TARGET slipd-camera)
  slipd_package(camera slipd-camera COMPONENTS camera SECTION electronics SCRIPTS camera
    DEPENDS "${slipd_same_version}, libslipd0 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})"
    SUMMARY "cameras that look at a gel, as sensors of slipd"
    TEXT "Follows dots or texture of the gel of GelSight Mini, DIGIT, TacTip and\n\
sensors of one's own, and sends slipd how far the surface has moved. Also\n\
reads video files.")
endif()

include(CPack)
