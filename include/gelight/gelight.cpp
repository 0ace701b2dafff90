// The one file to compile for programs that define GELIGHT_COMPILED: add it to your build, or link
// CMake's target gelight::compiled.

#if !defined(GELIGHT_COMPILED)
#define GELIGHT_COMPILED
#endif
#define GELIGHT_MAKES_COMPILED

#include "gelight/gelight.hpp"

#include "gelight/membrane/layer.hpp"
#include "gelight/sensor/calibrate.hpp"
