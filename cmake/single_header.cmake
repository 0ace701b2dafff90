# The target `single_header` writes all of gelight but the opt-in headers into one file,
# single_header/gelight.hpp in the build tree.

set(gelight_single_header ${CMAKE_CURRENT_BINARY_DIR}/single_header/gelight.hpp)
file(GLOB_RECURSE gelight_headers CONFIGURE_DEPENDS include/gelight/*.hpp)
add_custom_command(OUTPUT ${gelight_single_header}
  COMMAND ${CMAKE_COMMAND} -D INCLUDE_DIR=${CMAKE_CURRENT_SOURCE_DIR}/include
    -D LICENSE=${CMAKE_CURRENT_SOURCE_DIR}/LICENSE -D OUTPUT=${gelight_single_header}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/cmake/join_headers.cmake
  DEPENDS ${gelight_headers} LICENSE cmake/join_headers.cmake VERBATIM)
add_custom_target(single_header DEPENDS ${gelight_single_header})
