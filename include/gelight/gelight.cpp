// The one file to compile for programs that define GELIGHT_COMPILED: add it to your build, or link
// CMake's target gelight::compiled.

#include "gelight/compiled.hpp"

namespace gelight {

GELIGHT_FOR_ALL()

}  // namespace gelight
