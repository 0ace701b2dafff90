# cmake -D OUTPUT=... -D "SOURCES=a_test.cpp;b_test.cpp" -D ALONE=... -P merge_tests.cmake
#
# One source of several test files, each in a namespace of its own, after the headers of all: what
# every file costs, reading the headers and compiling what they all use, is paid once. A file with a
# line that ALONE, a regular expression, matches cannot be one of them.

cmake_minimum_required(VERSION 3.22)

set(headers "")
set(tests "")
foreach(source ${SOURCES})
  file(STRINGS ${source} holds REGEX "${ALONE}")
  if(holds)
    message(FATAL_ERROR "${source} has to be compiled alone now: configure again.\n  ${holds}")
  endif()
  file(STRINGS ${source} lines REGEX "^#include ")
  list(APPEND headers ${lines})
  get_filename_component(name ${source} NAME_WE)
  string(APPEND tests "namespace ${name} {\n#include \"${source}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES headers)
list(JOIN headers "\n" headers)
file(WRITE ${OUTPUT} "${headers}\n${tests}")
