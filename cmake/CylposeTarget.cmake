# What targets of ours have in common: the warnings, ccache where it is installed, and files that become part of them.

find_program(CYLPOSE_CCACHE ccache)
if(CYLPOSE_CCACHE AND PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Every checkout finds what another one compiled: the same sources in other folders.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      "CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}" CCACHE_NOHASHDIR=1 "${CYLPOSE_CCACHE}")
endif()

function(cylpose_warnings target)
  set(shadow -Wshadow)
  if(CMAKE_UNITY_BUILD)
    set(shadow)  # there a source's names shadow those of the source before it
  endif()
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic ${shadow} -Wconversion -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual)
  if(CYLPOSE_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# The library cylpose_<name> as its users know it: cylpose::<name> with a version and the public headers in HEADERS, a
# folder below include/, installed with the exported targets EXPORT.
function(cylpose_public_library name)
  cmake_parse_arguments(PARSE_ARGV 1 public "" "HEADERS;EXPORT" "")
  set(target cylpose_${name})
  add_library(cylpose::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} OUTPUT_NAME ${target}
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  file(GLOB headers CONFIGURE_DEPENDS include/${public_HEADERS}/*.hpp)
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${headers})
  target_include_directories(${target} PRIVATE src)
  cylpose_warnings(${target})
  install(TARGETS ${target} EXPORT ${public_EXPORT} FILE_SET HEADERS)
endfunction()

# Makes FILES (function=path) part of a target as C++ functions that return their bytes; HEADER declares them in
# NAMESPACE.
function(cylpose_embed target)
  cmake_parse_arguments(PARSE_ARGV 1 embed "" "NAMESPACE;HEADER" "FILES")
  set(source "${CMAKE_CURRENT_BINARY_DIR}/${target}_files.cpp")
  set(script "${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake")
  list(TRANSFORM embed_FILES REPLACE "^[^=]+=" "" OUTPUT_VARIABLE paths)
  add_custom_command(OUTPUT "${source}"
    COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${source}" "-DNAMESPACE=${embed_NAMESPACE}" "-DHEADER=${embed_HEADER}"
            "-DFILES=${embed_FILES}" -P "${script}"
    DEPENDS ${paths} "${script}"
    COMMENT "Embedding files into ${target}"
    VERBATIM)
  target_sources(${target} PRIVATE "${source}")
endfunction()
