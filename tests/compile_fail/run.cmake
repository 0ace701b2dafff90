# cmake -D SOURCE=... -D CXX=... -D INCLUDE_DIRS=... -P run.cmake
#
# The source must not compile, and the compiler must say why in the words that its first line
# expects, within a screenful.

cmake_minimum_required(VERSION 3.22)

set(flags -std=c++20 -fsyntax-only)
foreach(dir ${INCLUDE_DIRS})
  list(APPEND flags -isystem ${dir})
endforeach()
execute_process(COMMAND ${CXX} ${flags} ${SOURCE} RESULT_VARIABLE failed ERROR_VARIABLE said)
file(STRINGS ${SOURCE} first LIMIT_COUNT 1)
string(REGEX REPLACE "^// expect: " "" expected "${first}")
string(REGEX MATCHALL "\n" lines "${said}")
list(LENGTH lines lines)
if(NOT failed)
  message(FATAL_ERROR "${SOURCE} compiles.")
elseif(NOT said MATCHES "${expected}")
  message(FATAL_ERROR "The compiler does not speak of ${expected}:\n${said}")
elseif(lines GREATER 50)
  message(FATAL_ERROR "The compiler needs ${lines} lines:\n${said}")
endif()
