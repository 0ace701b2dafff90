#pragma once

#include <complex>
#include <cstddef>
#include <memory>

#include "gelight/core/types.hpp"

// How another library may do an elastic layer's Fourier transforms instead of Eigen's:
// membrane/fftw.hpp is an example.

namespace gelight {

/// An image in the corner of a periodic one, which is zero elsewhere.
struct PaddedSize {
  Index width = 0;     ///< of the image, in pixels
  Index height = 0;    ///< of the image, in pixels
  Index period_x = 0;  ///< a multiple of 4 with no prime factor but 2, 3 and 5
  Index period_y = 0;  ///< likewise
};

/// The discrete Fourier transform of real images of one padded size, in two dimensions. The
/// coefficients stand in an order of the backend's own, the same for every image of one period;
/// those that are conjugate to others may be left out. Their memory is aligned as operator new's.
/// Used by one thread at a time.
class PaddedTransform {
 public:
  virtual ~PaddedTransform() = default;
  /// How many coefficients there are.
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// The coefficients of an image whose rows are packed.
  virtual void forward(std::complex<double>* spectrum, const double* image) = 0;
  /// The image of coefficients, times period_x period_y, without its padding. Uses the
  /// coefficients up.
  virtual void inverse(double* image, std::complex<double>* spectrum) = 0;
};

/// A function that makes transforms: the choice of a backend. Null stands for Eigen's.
using FourierBackend = std::unique_ptr<PaddedTransform> (*)(const PaddedSize& size);

}  // namespace gelight
