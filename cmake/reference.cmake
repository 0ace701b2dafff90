# The target `reference` makes pages from the docstrings, reference/html in the build tree, and
# fails where something public has none, or a search of them would not find a function.

find_program(DOXYGEN doxygen)
if(DOXYGEN)
  configure_file(cmake/Doxyfile.in Doxyfile @ONLY)
  add_custom_target(reference
    COMMAND ${DOXYGEN} ${CMAKE_CURRENT_BINARY_DIR}/Doxyfile
    COMMAND ${CMAKE_COMMAND} -D REFERENCE=${CMAKE_CURRENT_BINARY_DIR}/reference/html
      -P ${CMAKE_CURRENT_SOURCE_DIR}/cmake/check_search.cmake
    VERBATIM)
endif()
