# The target `docs`: the API documentation of the public headers, in docs/html of the build folder. A warning is an error.

find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_PROJECT_BRIEF "${PROJECT_DESCRIPTION}")
  set(DOXYGEN_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/docs")
  set(DOXYGEN_FILE_PATTERNS *.hpp *.md)
  set(DOXYGEN_STRIP_FROM_INC_PATH "${PROJECT_SOURCE_DIR}/host/include" "${PROJECT_SOURCE_DIR}/graph/include"
    "${PROJECT_SOURCE_DIR}/cluster/include")
  set(DOXYGEN_USE_MDFILE_AS_MAINPAGE "${PROJECT_SOURCE_DIR}/docs/embedding.md")
  set(DOXYGEN_GENERATE_LATEX NO)
  set(DOXYGEN_HAVE_DOT NO)
  set(DOXYGEN_QUIET YES)
  set(DOXYGEN_WARNINGS YES)
  set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
  # What a name and a comment on the whole say need not be said again of every member.
  set(DOXYGEN_EXTRACT_ALL YES)
  set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
  set(DOXYGEN_EXCLUDE_SYMBOLS "*::Impl")
  doxygen_add_docs(docs host/include/cylpose graph/include/cylpose cluster/include/cylpose docs/embedding.md docs/threads.md
    docs/live.md)
endif()
