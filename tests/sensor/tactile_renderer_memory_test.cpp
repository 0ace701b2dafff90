#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <vector>

#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/heap_count.hpp"

using namespace gelight;

namespace {

template <class Renderer>
void check_frames(const Renderer& renderer) {
  const Image<float> rest(100, 80, 0.03f);
  Image<float> contact = rest, holed = rest, everywhere(100, 80, 0.02f);
  for (Index y = 30; y < 50; ++y) {
    for (Index x = 20; x < 90; x += 17) contact(x, y) = 0.025f;
    holed(y, y) = std::numeric_limits<float>::quiet_NaN();
  }
  Image<Rgb8> out(100, 80);
  auto frame = renderer.rest_frame();
  for (const auto* depth :
       std::initializer_list<const Image<float>*>{&rest, &contact, &holed, &everywhere, &contact}) {
    const std::size_t before = test::bytes_taken;
    renderer.render_into(out, *depth);
    renderer.render_next_into(frame, *depth);
    CHECK(test::bytes_taken - before == 0);
  }
}

}  // namespace

TEST_CASE("a frame after the first takes no memory, whatever it shows") {
  const Camera<float> camera{60, 60, 49.5, 39.5, 100, 80};
  const Image<float> rest(100, 80, 0.03f);
  const std::vector<Light<float>> lights{
      {Image<Vec3<float>>(100, 80, Vec3<float>(1, 0, 0)), {1, 0, 0}}};
  const std::array sigmas{3.0, 1.0};
  check_frames(TactileRenderer(camera, rest, lights));
  check_frames(
      TactileRenderer(camera, rest, PyramidMembrane<float>(sigmas), PhongLights<float>{lights}));
  check_frames(
      TactileRenderer(camera, rest, FlatGelSightMembrane<float>(), PhongLights<float>{lights}));
  check_frames(TactileRenderer(camera, rest, BulgingMembrane<float>(camera, 0.03f),
                               PhongLights<float>{lights}));
  check_frames(TactileRenderer(camera, rest,
                               ShadowedMembrane<float>(camera, GaussianMembrane<float>()),
                               PhongLights<float>{lights}));
}
