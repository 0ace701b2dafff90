# What only gelight's own tests, examples and benchmarks are built with.

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_EXTENSIONS OFF)

option(GELIGHT_NATIVE "Build for this machine's processor" OFF)

add_library(gelight_own INTERFACE)
target_link_libraries(gelight_own INTERFACE gelight::gelight)
target_compile_options(gelight_own INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow $<$<BOOL:${GELIGHT_NATIVE}>:-march=native>)

# The packages of the opt-in headers and of the tests; Debian's names are in dependencies.sh.
find_package(OpenMesh QUIET)
find_path(STB_INCLUDE_DIR stb_image.h PATH_SUFFIXES stb)
