# cmake -D VERSION=... -P cmake/check_version.cmake: the vcpkg port, which cannot read a header, and
# the newest entry of the changelog name the version of gelight/version.hpp.
cmake_minimum_required(VERSION 3.22)
get_filename_component(root "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
file(READ "${root}/cmake/ports/vcpkg/vcpkg.json" port)
string(JSON of_port GET "${port}" version)
file(STRINGS "${root}/CHANGELOG.md" newest LIMIT_COUNT 1 REGEX "^## ")
string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+" of_changelog "${newest}")
foreach(place port changelog)
  if(NOT of_${place} STREQUAL VERSION)
    message(SEND_ERROR "the ${place} says ${of_${place}}, gelight/version.hpp ${VERSION}")
  endif()
endforeach()
