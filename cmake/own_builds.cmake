# What only gelight's own tests, examples and benchmarks are built with.

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_EXTENSIONS OFF)

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # To look for memory to give back only from a gigabyte on takes less time.
  add_compile_options(--param=ggc-min-heapsize=1000000)
  target_compile_options(gelight_compiled PRIVATE --param=ggc-min-heapsize=1000000)
endif()

# Tests that are compiled for a debugger, in five sixths of the time, still spend theirs in what they
# link.
if(CMAKE_CXX_FLAGS_RELEASE MATCHES "-Og")
  target_compile_options(gelight_compiled PRIVATE -O1)
endif()

option(GELIGHT_NATIVE "Build for this machine's processor" OFF)

add_library(gelight_own INTERFACE)
target_link_libraries(gelight_own INTERFACE gelight::gelight)
target_compile_options(gelight_own INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow $<$<BOOL:${GELIGHT_NATIVE}>:-march=native>)

# What programs link that are only run: the compiled library where it is built, which it is where
# tests are, else the headers alone.
add_library(gelight_once INTERFACE)
if(GELIGHT_BUILD_COMPILED)
  target_link_libraries(gelight_once INTERFACE gelight::compiled)
endif()
# What they say of what they cannot do.
add_library(gelight_words STATIC EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/examples/support/plain_words.cpp)
target_compile_features(gelight_words PRIVATE cxx_std_20)
target_link_libraries(gelight_once INTERFACE gelight_words)
set(GELIGHT_PROGRAM_OPTIONS "" CACHE STRING
  "Compiler options of benchmarks and examples that are compiled to see that they compile")

# The packages of the opt-in headers and of the tests; Debian's names are in dependencies.sh.
find_package(OpenMesh QUIET)
if(TARGET OpenMeshCore)
  # Reads meshes from files for programs: compiled once, for OpenMesh's headers are dear.
  add_library(gelight_mesh_file STATIC EXCLUDE_FROM_ALL
    ${PROJECT_SOURCE_DIR}/examples/support/mesh_file.cpp)
  target_link_libraries(gelight_mesh_file PRIVATE gelight_own gelight_once PUBLIC OpenMeshCore)
endif()
find_path(CGAL_HEADERS CGAL/Surface_mesh.h)
find_path(OPENCV_HEADERS opencv2/core/mat.hpp PATH_SUFFIXES opencv4)
find_library(OPENCV_CORE opencv_core)
find_path(CHOLMOD_HEADERS cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD cholmod)
find_path(FFTW_HEADERS fftw3.h)
find_library(FFTW fftw3)
find_path(EMBREE_HEADERS embree3/rtcore.h)
find_library(EMBREE embree3)

# What may be absent, and the headers and tests that then stay out.
add_library(gelight_optional INTERFACE)
target_link_libraries(gelight_optional INTERFACE $<TARGET_NAME_IF_EXISTS:OpenMeshCore>)
set(gelight_absent "^$")
if(NOT CGAL_HEADERS)
  string(APPEND gelight_absent "|views/cgal")
endif()
# Links a package whose headers and library these variables name, or leaves out what needs it.
macro(gelight_link_optional headers library needing)
  if(${headers} AND ${library})
    target_include_directories(gelight_optional SYSTEM INTERFACE ${${headers}})
    target_link_libraries(gelight_optional INTERFACE ${${library}})
  else()
    string(APPEND gelight_absent "|${needing}")
  endif()
endmacro()
gelight_link_optional(OPENCV_HEADERS OPENCV_CORE "views/opencv")
gelight_link_optional(CHOLMOD_HEADERS CHOLMOD "mesh/cholmod|_cholmod_")
gelight_link_optional(FFTW_HEADERS FFTW "membrane/fftw|_fftw_")
gelight_link_optional(EMBREE_HEADERS EMBREE "light/traced|_embree_")
find_path(STB_INCLUDE_DIR stb_image.h PATH_SUFFIXES stb)
