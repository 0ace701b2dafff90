#include "gelight/membrane/fftw.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/layer/eigen_fourier.hpp"

using namespace gelight;

TEST_CASE("FFTW and Eigen press alike") {
  const double rest = 0.03, pitch = 1e-4;
  const Camera<double> eye{300, 290, 30, 22, 61, 45};
  Image<double> depth(61, 45);
  for (Index y = 0; y < 45; ++y) {
    for (Index x = 0; x < 61; ++x) {
      depth(x, y) = rest + pitch * (-2 + 0.02 * (x - 28) * (x - 28) + 0.01 * (y - 25) * (y - 25));
    }
  }
  const Gel gel{1e5, 0.45, 20 * pitch, 0.4};
  const auto eigen = ElasticLayer(eye, rest, gel).press(depth, {.shift = {2e-5, 1e-5}});
  const auto fftw =
      ElasticLayer(eye, rest, gel, {.fourier = fftw_backend}).press(depth, {.shift = {2e-5, 1e-5}});
  CHECK(eigen.converged);
  CHECK(eigen.convolutions == fftw.convolutions);
  CHECK((eigen.force - fftw.force).norm() < 1e-9 * eigen.force.norm());
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    CHECK((eigen.displacement.pixels()[i] - fftw.displacement.pixels()[i]).norm() < 1e-9 * pitch);
  }
}

TEST_CASE("both transforms are inverse to themselves, padded") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const PaddedSize size :
       {PaddedSize{5, 3, 8, 4}, {12, 20, 12, 20}, {1, 1, 4, 4}, {31, 17, 60, 36}}) {
    const auto count = static_cast<std::size_t>(size.width * size.height);
    std::vector<double> image(count), back(count);
    for (double& value : image) value = normal(random);
    for (const FourierBackend backend : {&fftw_backend, &detail::eigen_backend}) {
      const auto transform = backend(size);
      std::vector<std::complex<double>> spectrum(transform->size());
      transform->forward(spectrum.data(), image.data());
      transform->inverse(back.data(), spectrum.data());
      for (std::size_t i = 0; i < count; ++i) {
        CHECK(std::abs(back[i] / (size.period_x * size.period_y) - image[i]) < 1e-14);
      }
    }
  }
}
