# Headers of libraries take most of the time of a build. The presets for tests read those that most sources of a part of the tree see
# once for that part. The other presets read them for every source, which shows a missing #include.
option(SLIPD_PRECOMPILE "Read the headers that most sources see once" OFF)

# slipd_precompiled(name [PROGRAMS] LINKS … HEADERS …): for libraries or PROGRAMS, what slipd_use_precompiled takes from here on, in this folder and those below. To be called
# where all compiler options are set: they must be the same for who reads the headers and who uses them.
macro(slipd_precompiled name)
  if(SLIPD_PRECOMPILE)
    cmake_parse_arguments(ARG "PROGRAMS" "" "HEADERS;LINKS" ${ARGN})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/${name}.cpp CONTENT "")
    add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/generated/${name}.cpp)
    target_link_libraries(${name} PRIVATE slipd_flags ${ARG_LINKS})
    if(ARG_PROGRAMS)
      set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
      target_compile_options(${name} PRIVATE -fPIE)
    endif()
    target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
    set(SLIPD_PRECOMPILED ${name})
  endif()
endmacro()

# For a target without compiler options of its own. A source with such options is left out by SKIP_PRECOMPILE_HEADERS.
function(slipd_use_precompiled target)
  if(SLIPD_PRECOMPILED)
    target_precompile_headers(${target} REUSE_FROM ${SLIPD_PRECOMPILED})
  endif()
endfunction()
