# cmake -P cmake/check_umbrella.cmake: gelight.hpp includes every door but the opt-in ones. Rooms,
# the folders behind doors, come with these, as do doors of detail alone.
cmake_minimum_required(VERSION 3.22)
get_filename_component(root "${CMAKE_CURRENT_LIST_DIR}/../include" ABSOLUTE)
file(GLOB headers RELATIVE "${root}" "${root}/gelight/*/*.hpp")
list(FILTER headers EXCLUDE REGEX "/io/|/geodesic/(backtrace|heat_engine|sampled_error)\\.hpp|/light/traced\\.hpp|/sensor/(calibrat|plan)|/shading/fitted|/membrane/(layer|layer_membrane|fftw)\\.hpp|/mesh/(cholmod|sparse_factor)\\.hpp|/views/(cgal|eigen|opencv|openmesh)\\.hpp")
file(READ "${root}/gelight/gelight.hpp" umbrella)
foreach(header ${headers})
  string(FIND "${umbrella}" "#include \"${header}\"" place)
  if(place EQUAL -1)
    message(SEND_ERROR "gelight.hpp does not include ${header}")
  endif()
endforeach()
