// The library compiles by Emscripten: all of it that needs no package but Eigen.

#include "gelight/gelight.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/layer_membrane.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/calibrated.hpp"
#include "gelight/sensor/plan.hpp"
#include "gelight/views/eigen.hpp"

// Of the function templates, those that every machine would have to cast, count and run alike.
void used() {
  gelight::parallel_for(1, 1, [](gelight::Index) {});
}
