// An elastic layer, with Eigen's Fourier transforms: see support/layer.hpp.

#include "support/layer.hpp"

namespace {
[[maybe_unused]] const bool registered = (gelight::bench::register_layer("eigen", nullptr), true);
}  // namespace
