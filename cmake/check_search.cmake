# cmake -D REFERENCE=FOLDER -P cmake/check_search.cmake: a search of the built reference finds a
# class, free functions and a page.
cmake_minimum_required(VERSION 3.22)
file(GLOB parts "${REFERENCE}/search/all_*.js")
set(index)
foreach(part IN LISTS parts)
  file(READ "${part}" text)
  string(APPEND index "${text}")
endforeach()
foreach(word rasterize geodesic_field exactsolver check transport)
  string(REPLACE "_" "_5f" entry "${word}")  # so it is written there, and a number behind it
  string(FIND "${index}" "['${entry}_" place)
  if(place EQUAL -1)
    message(SEND_ERROR "a search of ${REFERENCE} does not find ${word}")
  endif()
endforeach()
