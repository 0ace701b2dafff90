#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gelight/membrane/layer.hpp"

using namespace gelight;

TEST_CASE("an object held by friction is as near to the surface as the residual tells") {
  constexpr double inf = std::numeric_limits<double>::infinity();
  constexpr double rest = 0.03, pitch = 1e-4, press = 3 * pitch, modulus = 1e5;
  const Camera<double> eye{300, 300 / 0.9, 48, 40, 97, 81};
  Image<double> depth(97, 81);
  for (Index v = 0; v < 81; ++v) {
    for (Index u = 0; u < 97; ++u) {
      const double x = u - 49.7, y = 0.9 * (v - 36.8);
      depth(u, v) = rest - press * (1 - (x * x + y * y) / 1800);
    }
  }
  for (const double friction : {0.3, 0.8}) {
    for (const double nu : {0.0, 0.3, 0.48}) {
      for (const double h : {8.0, 30.0, inf}) {
        const ElasticLayer layer(eye, rest, {modulus, nu, h * pitch, friction},
                                 {.sideways = false});
        const auto contact = layer.press(depth, {.shift = {1.5 * pitch, -pitch}, .twist = 0.02});
        const detail::LayerGrid grid{97, 81, 0.9, h, nu};
        const detail::PressureGreen green(grid, detail::layer_correction(grid));
        const double softness = green.down(0, 0) * (2 + 2 * nu) / modulus * pitch;
        CAPTURE(friction);
        CAPTURE(nu);
        CAPTURE(h);
        CHECK(contact.converged);
        double off = 0;
        for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
          const double through = contact.depth.pixels()[i] - depth.pixels()[i];
          // Where the gap is wider than that, the pressure is to close no more.
          const double closing = softness * contact.pressure.pixels()[i];
          off = std::max(off, through > 0 ? through : std::min(-through, closing));
        }
        CHECK(off <= (contact.residual + 1e-6) * press);
      }
    }
  }
}
