# cmake -D OUTPUT=... -D "SOURCES=a_test.cpp;b_test.cpp" -D ALONE=... [-D PROGRAMS=ON] -P merge_sources.cmake
#
# One source of several, each in a namespace of its own, after the headers of all: what every file
# costs, reading the headers and compiling what they all use, is paid once. A file with a line that
# ALONE, a regular expression, matches cannot be one of them. PROGRAMS: each has a `main`, and the
# first argument says whose is to be called with the others; without a name that is known the program
# tells those that are.

cmake_minimum_required(VERSION 3.22)

set(headers "")
set(bodies "")
set(calls "")
set(names "")
foreach(source ${SOURCES})
  file(STRINGS ${source} holds REGEX "${ALONE}")
  if(holds)
    message(FATAL_ERROR "${source} has to be compiled alone now: configure again.\n  ${holds}")
  endif()
  file(STRINGS ${source} lines REGEX "^#include ")
  list(APPEND headers ${lines})
  get_filename_component(name ${source} NAME_WE)
  string(APPEND bodies "namespace ${name} {\n#include \"${source}\"\n}\n")
  string(APPEND names " ${name}")
  string(APPEND calls "  if (name == \"${name}\") return ${name}::main(count - 1, arguments + 1);\n")
endforeach()
if(PROGRAMS)
  list(APPEND headers "#include <cstdio>" "#include <string>")
  string(APPEND bodies "int main(int count, char** arguments) {\n"
    "  const std::string name = count > 1 ? arguments[1] : \"\";\n${calls}"
    "  std::fputs(\"The first argument is one of:${names}\\n\", stderr);\n  return 2;\n}\n")
endif()
list(REMOVE_DUPLICATES headers)
list(JOIN headers "\n" headers)
file(WRITE ${OUTPUT} "${headers}\n${bodies}")
