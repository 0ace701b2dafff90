# cmake -D INCLUDE_DIR=... -D LICENSE=... -D OUTPUT=... -P join_headers.cmake
#
# Writes gelight/gelight.hpp and what it includes into one file: every header once, behind those
# that it includes; the standard library's and Eigen's headers once, sorted, in front. Bodies
# (x/body.hpp) come behind the doors that they belong to, which include them.

cmake_minimum_required(VERSION 3.22)

set(joined "")
set(done "")
set(foreign "")

# Appends a header to `joined`. Text is never taken apart as a list: it is full of semicolons.
function(join header)
  if(header IN_LIST done)
    return()
  endif()
  list(APPEND done ${header})
  file(READ ${INCLUDE_DIR}/${header} text)
  set(body "")
  if(text MATCHES "\n#if defined\\(GELIGHT_BODIES\\)\n#include \"([^\"]+)\"\n#endif\n")
    set(body ${CMAKE_MATCH_1})
    string(REPLACE "${CMAKE_MATCH_0}" "" text "${text}")
  endif()
  string(REGEX MATCHALL "#include \"gelight/[^\"]+\"" own "${text}")
  foreach(line ${own})
    string(REGEX REPLACE "#include \"(.*)\"" "\\1" included ${line})
    join(${included})
  endforeach()
  string(REGEX MATCHALL "#include <[^>]+>" others "${text}")
  list(APPEND foreign ${others})
  string(REGEX REPLACE "#pragma once\n|#include [^\n]*\n" "" text "${text}")
  string(REGEX REPLACE "\n\n\n+" "\n\n" text "${text}")
  string(STRIP "${text}" text)
  set(joined "${joined}\n// ${header}\n\n${text}\n")
  if(body)
    join(${body})
  endif()
  set(done "${done}" PARENT_SCOPE)
  set(foreign "${foreign}" PARENT_SCOPE)
  set(joined "${joined}" PARENT_SCOPE)
endfunction()

join(gelight/gelight.hpp)
list(REMOVE_DUPLICATES foreign)
list(SORT foreign)
list(JOIN foreign "\n" foreign)
file(READ ${LICENSE} license)
string(REGEX REPLACE "\n" "\n// " license "// ${license}")
string(REGEX REPLACE " +(\n|$)" "\\1" license "${license}")
file(WRITE ${OUTPUT} "${license}\n#pragma once\n\n${foreign}\n${joined}")
