# slipd_test(name SOURCES … [LINKS …] [LABEL unit|system|vm] [TIMEOUT seconds]): one test executable of GoogleTest and
# GoogleMock, a CTest test for each of its cases. LABEL is `unit` unless said otherwise: `system` starts real programs,
# `vm` boots a kernel. TIMEOUT is for what hangs: far longer than any case takes on a machine that does much else, so that no
# verdict depends on the machine's speed. Cases are listed when CTest runs, not while building, so a build never runs what it has built.
include(GoogleTest)
if(CMAKE_CROSSCOMPILING)  # Debian has its sources for all, built ones for each architecture
  add_subdirectory(/usr/src/googletest ${PROJECT_BINARY_DIR}/googletest EXCLUDE_FROM_ALL)
else()
  find_package(GTest REQUIRED)
endif()

function(slipd_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LINKS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 1200)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  set(counts_heap ${ARG_SOURCES})  # replaces operator new, which the compiler must not see through
  list(FILTER counts_heap INCLUDE REGEX "heap_count[.]cpp$")
  set_source_files_properties(${counts_heap} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
  target_link_libraries(${name} PRIVATE slipd_flags ${ARG_LINKS} GTest::gmock GTest::gtest_main)
  set(SLIPD_PRECOMPILED ${SLIPD_TEST_PRECOMPILED})
  slipd_use_precompiled(${name})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test-bin)
  target_compile_definitions(${name} PRIVATE SLIPD_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SLIPD_BINARY_DIR="${PROJECT_BINARY_DIR}")
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 300
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
endfunction()
