// An elastic layer, with FFTW's Fourier transforms: see support/layer.hpp.

#include "gelight/membrane/fftw.hpp"
#include "support/layer.hpp"

namespace {
[[maybe_unused]] const bool registered =
    (gelight::bench::register_layer("fftw", gelight::fftw_backend), true);
}  // namespace
