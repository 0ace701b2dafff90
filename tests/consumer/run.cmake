# cmake -D HOW=... -D SOURCE_DIR=... -D WORK_DIR=... -D CXX=... -P run.cmake
#
# Builds the consumer from nothing in one way, runs it, and compares what it prints with what is
# right. HOW: headers (gelight on its include path, no CMake), single_header, pkg-config,
# find_package, add_subdirectory or FetchContent; long_double, by the headers; or compiled, which
# installs the library that BUILD_DIR holds and compares its results with those of the headers, bit
# for bit. FLAGS are those of the compiler.

cmake_minimum_required(VERSION 3.22)

set(consumer ${SOURCE_DIR}/tests/consumer)
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK_DIR} COMMAND_ERROR_IS_FATAL ANY
    COMMAND_ECHO STDOUT)
endfunction()

function(compile main)
  run(${CXX} -Wall -Wextra -Werror ${ARGN} ${consumer}/${main}.cpp -o consumer)
endfunction()

separate_arguments(FLAGS UNIX_COMMAND "${FLAGS}")

# What is installed must work wherever it is moved to.
function(install_and_move)
  run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B gelight -D GELIGHT_BUILD_TESTS=OFF
    -D GELIGHT_BUILD_EXAMPLES=OFF -D CMAKE_CXX_COMPILER=${CXX})
  run(${CMAKE_COMMAND} --install gelight --prefix ${WORK_DIR}/first)
  file(RENAME ${WORK_DIR}/first ${WORK_DIR}/moved)
endfunction()

function(build_with_cmake)
  run(${CMAKE_COMMAND} -S ${consumer} -B . -D HOW=${HOW} -D GELIGHT_DIR=${SOURCE_DIR}
    -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_PREFIX_PATH=${WORK_DIR}/moved)
  run(${CMAKE_COMMAND} --build .)
endfunction()

if(HOW STREQUAL "single_header")
  run(${CMAKE_COMMAND} -D INCLUDE_DIR=${SOURCE_DIR}/include -D LICENSE=${SOURCE_DIR}/LICENSE
    -D OUTPUT=${WORK_DIR}/gelight/gelight.hpp -P ${SOURCE_DIR}/cmake/join_headers.cmake)
  # Its two files as one, which takes half the time.
  compile(main ${FLAGS} -include ${consumer}/second.cpp -I ${WORK_DIR} -isystem ${EIGEN_DIR})
elseif(HOW STREQUAL "pkg-config")
  install_and_move()
  set(ENV{PKG_CONFIG_PATH} ${WORK_DIR}/moved/share/pkgconfig)
  execute_process(COMMAND pkg-config --cflags --libs gelight COMMAND_ERROR_IS_FATAL ANY
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  compile(one_door ${FLAGS} ${flags})
elseif(HOW STREQUAL "find_package")
  install_and_move()
  build_with_cmake()
elseif(HOW STREQUAL "compiled")
  run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/first)
  file(RENAME ${WORK_DIR}/first ${WORK_DIR}/moved)
  build_with_cmake()
  # By the headers, with a second file that includes them: nothing may be defined twice.
  run(${CXX} ${FLAGS} -Wall -Wextra -Werror -I ${SOURCE_DIR}/include -isystem ${EIGEN_DIR}
    ${consumer}/bits.cpp ${consumer}/second.cpp -o plain)
  foreach(program plain bits)
    execute_process(COMMAND ${WORK_DIR}/${program} COMMAND_ERROR_IS_FATAL ANY
      OUTPUT_VARIABLE of_${program})
  endforeach()
  if(NOT of_plain STREQUAL of_bits)
    message(FATAL_ERROR "By the headers:\n${of_plain}by the library:\n${of_bits}")
  endif()
elseif(HOW STREQUAL "headers")
  compile(main ${FLAGS} ${consumer}/second.cpp -I ${SOURCE_DIR}/include -isystem ${EIGEN_DIR})
elseif(HOW STREQUAL "long_double")
  compile(long_double ${FLAGS} -I ${SOURCE_DIR}/include -isystem ${EIGEN_DIR})
else()
  build_with_cmake()
endif()

execute_process(COMMAND ${WORK_DIR}/consumer COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE printed)
message("${printed}")
if(HOW MATCHES "^(pkg-config|find_package|add_subdirectory|FetchContent|long_double)$")
  if(NOT printed STREQUAL "across a sheet of 4 x 3: 5.000000000\n")
    message(FATAL_ERROR "This is not what one door must print.")
  endif()
elseif(NOT printed MATCHES "across a sheet of 4 x 3: 5\\.000000000000\n"
    OR NOT printed MATCHES "by fast marching, in the second file: 5\\.000000000\n"
    OR NOT printed MATCHES "untouched, the image is the image at rest\n")
  message(FATAL_ERROR "This is not what the consumer must print.")
endif()
