#include "gelight/membrane/layer_membrane.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double rest = 0.03, pitch = 1e-4;

Camera<double> camera() { return {rest / pitch, rest / pitch, 49.5, 39.5, 100, 80}; }

// A ball that on a half-space touches a circle of 10 pixels, pressed in by 2.
Image<double> ball(double x0, double y0) {
  Image<double> depth(100, 80);
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) {
      const double r2 = (x - x0) * (x - x0) + (y - y0) * (y - y0);
      depth(x, y) = rest - pitch * 2 * (1 - r2 / 200);
    }
  }
  return depth;
}

struct Laid {  // a surface that is known
  struct Workspace {};
  Index reach() const { return whole_image; }
  Workspace make_workspace(Index, Index) const { return {}; }
  void press_into(ImageView<double> out, const Press<double>& press, Workspace&) const {
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) out(x, y) = surface(x, y);
    }
  }
  Image<double> surface;
};

}  // namespace

TEST_CASE("a renderer shows the layer's surface, cold the same bits in any order of frames") {
  const Image<double> gel_at_rest(100, 80, rest);
  const ElasticLayer layer(camera(), rest, {1e5, 0.49, 2e-3}, {.sideways = false});
  const PhongLights<double> lights{
      {{Image<Vec3<double>>(100, 80, Vec3<double>(0.8, 0, 0.6)), {1, 0.5, 0}}}};
  const TactileRenderer renderer(camera(), gel_at_rest, LayerMembrane<double>(layer), lights);
  auto frame = renderer.rest_frame();
  for (const double x : {30.0, 44.5, 60.0}) {
    const auto depth = ball(x, 35);
    const TactileRenderer laid(camera(), gel_at_rest, Laid{layer.press(depth).depth}, lights);
    renderer.render_next_into(frame, depth);
    CHECK(frame.image == renderer.render(depth));
    CHECK(renderer.render(depth) == laid.render(depth));
  }
  CHECK(renderer.render(Image<double>(100, 80, inf)) == renderer.rest_image());
  // The cheap model shows nearly the same.
  const TactileRenderer cheap(camera(), gel_at_rest,
                              BulgingMembrane<double>(camera(), rest, layer.gel()), lights);
  const auto depth = ball(44.5, 35);
  const auto a = renderer.render(depth), b = cheap.render(depth);
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(a.pixels()[i][c] - b.pixels()[i][c]);
  }
  CHECK(sum / static_cast<double>(3 * a.pixels().size()) < 0.5);
}

TEST_CASE("warm from frame to frame: the same surface within the tolerance, for less") {
  const Image<double> gel_at_rest(100, 80, rest);
  const ElasticLayer layer(camera(), rest, {1e5, 0.3, inf}, {.sideways = false});
  const LayerMembrane<double> cold(layer), warm(layer, {}, true);
  auto cold_work = cold.make_workspace(100, 80), warm_work = warm.make_workspace(100, 80);
  Image<double> from_cold(100, 80), from_warm(100, 80);
  int cold_convolutions = 0, warm_convolutions = 0;
  for (int step = 0; step < 8; ++step) {
    const auto depth = ball(44.5 + 0.1 * step, 35);
    const Press<double> press{depth.view(), gel_at_rest.view(), {0, 0, 100, 80}};
    cold.press_into(from_cold, press, cold_work);
    warm.press_into(from_warm, press, warm_work);
    if (step == 0) continue;
    cold_convolutions += cold_work.contact->convolutions;
    warm_convolutions += warm_work.contact->convolutions;
    for (std::size_t i = 0; i < from_cold.pixels().size(); ++i) {
      CHECK(std::abs(from_cold.pixels()[i] - from_warm.pixels()[i]) < 2e-3 * 2 * pitch);
    }
  }
  MESSAGE(cold_convolutions, " convolutions cold, ", warm_convolutions, " warm");
  CHECK(warm_convolutions < cold_convolutions);
}

TEST_CASE("by a force, and with a hole in what is seen") {
  const Image<double> gel_at_rest(100, 80, rest);
  const ElasticLayer layer(camera(), rest, {1e5, 0.48, 3e-3}, {.sideways = false});
  const LayerMembrane<double> pressed(layer, {.force = 0.02});
  auto work = pressed.make_workspace(100, 80);
  auto depth = ball(50, 40);
  depth(20, 20) = -1;
  Image<double> surface(100, 80);
  pressed.press_into(surface, {depth.view(), gel_at_rest.view(), {0, 0, 100, 80}}, work);
  CHECK(-work.contact->force.z() == gelight::test::approx(0.02).epsilon(2e-3));
  for (const double z : surface.pixels()) CHECK(std::isfinite(z));
}

TEST_CASE("a contact that is far from converged is not shown") {
  const Image<double> gel_at_rest(100, 80, rest);
  auto depth = ball(50, 40);  // rough
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) depth(x, y) += pitch * ((7 * x + 13 * y + x * y) % 5);
  }
  const ElasticLayer<double> layer(camera(), rest, {1e5, 0.48, 3e-3},
                                   {.most_iterations = 1, .sideways = false});
  const auto contact = layer.press(depth);
  REQUIRE(!contact.converged);
  REQUIRE(contact.residual > LayerMembrane<double>::most_residual);
  const LayerMembrane<double> hasty(layer);
  auto work = hasty.make_workspace(100, 80);
  Image<double> surface(100, 80, 7);
  CHECK_THROWS_AS(
      hasty.press_into(surface, {depth.view(), gel_at_rest.view(), {0, 0, 100, 80}}, work),
      InvalidInput);
  for (const double z : surface.pixels()) CHECK(z == 7);
}

TEST_CASE("a renderer's Gaussian for a gel that it is told") {
  const Gel gel{1e5, 0.3, 3e-3};
  const auto options = TactileOptions::for_gel(gel, 2e-3, pitch);
  CHECK(options.smoothing_sigma == gelight::test::approx(gaussian_sigma(gel, 2e-3) / pitch));
  CHECK(options.smoothing_radius >= 4 * options.smoothing_sigma);
  CHECK(options.smoothing_radius < 4 * options.smoothing_sigma + 1);
  CHECK_THROWS_AS((void)TactileOptions::for_gel(gel, 2e-3, 0), InvalidInput);
  CHECK_THROWS_AS((void)TactileOptions::for_gel(gel, -1, pitch), InvalidInput);
  // A Gaussian too wide for an image, or for an integer.
  for (const double tiny : {1e-9, 1e-13, 1e-300}) {
    CHECK_THROWS_AS((void)TactileOptions::for_gel(gel, 2e-3, tiny), InvalidInput);
  }
}

TEST_CASE("a renderer of another rest depth is told so") {
  const ElasticLayer layer(camera(), rest, {1e5, 0.3, inf}, {.sideways = false});
  const LayerMembrane<double> membrane(layer);
  const auto depth = ball(49.5, 39.5);
  for (const double other : {0.9 * rest, rest + 0.02 * pitch, 2 * rest}) {
    CHECK_THROWS_AS((void)surface_depth(membrane, depth, Image<double>(100, 80, other)),
                    InvalidInput);
  }
  CHECK(surface_depth(membrane, depth, Image<double>(100, 80, rest + 0.005 * pitch))(50, 40) <
        rest);
}

TEST_CASE(
    "where a renderer has no membrane nor has a layer, where it has one a layer has it, too") {
  const auto depth = ball(50, 40);
  const Image<double> full(100, 80, rest);
  auto holed = full;
  holed(70, 20) = std::numeric_limits<double>::quiet_NaN();
  const auto layer_of = [](const Image<double>& seen) {
    return LayerMembrane<double>(
        ElasticLayer<double>(camera(), seen, {1e5, 0.48, 3e-3}, {.sideways = false}));
  };
  for (const auto* const seen : {&std::as_const(full), &std::as_const(holed)}) {
    const auto surface = surface_depth(layer_of(*seen), depth, holed);
    for (Index y = 0; y < 80; ++y) {
      for (Index x = 0; x < 100; ++x) {
        CHECK(std::isnan(surface(x, y)) == (x == 70 && y == 20));
      }
    }
  }
  for (const double none : {std::numeric_limits<double>::quiet_NaN(), inf, 0.0, -1.0}) {
    holed(70, 20) = none;
    CHECK(test::contains(test::refusal([&] { (void)surface_depth(layer_of(holed), depth, full); }),
                         "at pixel (70, 20) the renderer's rest depth is 0.03 m, the layer's"));
  }
}

TEST_CASE("no force brings the surface behind the camera") {
  const ElasticLayer layer(camera(), rest, {1e5, 0.3, inf}, {.sideways = false});
  const Image<double> plate(100, 80, rest);
  for (const double force : {100.0, 1000.0}) {
    CHECK_THROWS_AS((void)layer.press(plate, {.force = force}), InvalidInput);
  }
  CHECK(layer.press(plate, {.force = 0.1}).converged);
}

TEST_CASE("a layer of another size than the images is refused, before a frame") {
  const Image<double> small(8, 8, rest), large(100, 80, rest);
  const Camera<double> narrow{rest / pitch, rest / pitch, 3.5, 3.5, 8, 8};
  const LayerMembrane<double> membrane(
      ElasticLayer(narrow, rest, {1e5, 0.49, 2e-3}, {.sideways = false}));
  const std::string words = "images of 100 x 80 pixels are not of the membrane's 8 x 8";
  CHECK(test::refusal([&] { (void)surface_depth(membrane, large, large); }) == words);
  const PhongLights<double> lights{
      {{Image<Vec3<double>>(100, 80, Vec3<double>(0.8, 0, 0.6)), {1, 0.5, 0}}}};
  const auto make = [&] { TactileRenderer(camera(), large, membrane, lights); };
  CHECK(test::refusal(make) == words);
}
