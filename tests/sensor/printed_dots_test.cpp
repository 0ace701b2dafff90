#include "gelight/sensor/printed_dots.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "gelight/membrane/layer.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::contains;
using test::refusal;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double rest = 0.03;
constexpr std::array<double, 3> black{0, 0, 0};
const Camera<double> eye{300, 300, 40, 30, 81, 61};

Image<Rgb8> white(Index width = 81, Index height = 61) {
  return {width, height, Rgb8{255, 255, 255}};
}

// The ink on white: how many pixels, where, and the second moments about there.
struct Ink {
  double area = 0;
  Vec2<double> centre{0, 0};
  double xx = 0, xy = 0, yy = 0;
};

Ink ink_of(const Image<Rgb8>& image) {
  Ink ink;
  for (const bool has_centre : {false, true}) {
    for (Index y = 0; y < image.height(); ++y) {
      for (Index x = 0; x < image.width(); ++x) {
        const double share = 1 - image(x, y)[1] / 255.0;
        if (share == 0) continue;
        if (!has_centre) {
          ink.area += share;
          ink.centre += share * Vec2<double>(x, y);
          continue;
        }
        const Vec2<double> off = Vec2<double>(x, y) - ink.centre;
        // Less what a pixel is wide.
        ink.xx += share * (off.x() * off.x() - 1.0 / 12) / ink.area;
        ink.xy += share * off.x() * off.y() / ink.area;
        ink.yy += share * (off.y() * off.y() - 1.0 / 12) / ink.area;
      }
    }
    if (!has_centre) ink.centre /= ink.area;
  }
  return ink;
}

PrintedDots one_dot(const Vec2<double>& centre, double pixels) {
  return {eye, Image<double>(81, 61, rest), std::vector{centre}, pixels * rest / 300, black};
}

}  // namespace

TEST_CASE("at rest a dot is a disc, wherever between the pixels it is") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(20, 40), size(0.3, 9);
  for (int i = 0; i < 50; ++i) {
    const Vec2<double> centre(place(random), place(random));
    const double radius = size(random);
    auto image = white();
    one_dot(centre, radius).draw_into(image);
    const Ink ink = ink_of(image);
    CHECK(ink.area == gelight::test::approx(pi * radius * radius).epsilon(0.02 + 0.02 / radius));
    CHECK((ink.centre - centre).norm() < 0.02 + 0.04 / radius);
    if (radius < 2) continue;
    CHECK(ink.xx == gelight::test::approx(radius * radius / 4).epsilon(0.12 / radius));
    CHECK(ink.yy == gelight::test::approx(radius * radius / 4).epsilon(0.12 / radius));
    CHECK(std::abs(ink.xy) < 0.01 * radius * radius);
  }
}

TEST_CASE("a dot goes where the gel takes it, stretched and turned") {
  // A linear map takes a disc of radius r to an ellipse of the second moments r^2 / 4 A A^T.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> entry(-0.5, 0.5);
  for (int i = 0; i < 30; ++i) {
    const double a = 1 + entry(random), b = entry(random), c = entry(random), d = 1 + entry(random);
    const Vec2<double> centre(40.3, 29.6), shift(3.7 * entry(random), 5 * entry(random));
    const auto field = [&](const Vec2<double>& p) -> Vec2<double> {
      const Vec2<double> r = p - centre;
      return shift + Vec2<double>(a * r.x() + b * r.y(), c * r.x() + d * r.y()) - r;
    };
    auto image = white();
    one_dot(centre, 6).draw_into(image, field);
    const Ink ink = ink_of(image);
    CHECK(ink.area == gelight::test::approx(36 * pi * std::abs(a * d - b * c)).epsilon(0.02));
    CHECK((ink.centre - centre - shift).norm() < 0.03);
    CHECK(std::abs(ink.xx - 9 * (a * a + b * b)) < 0.3);
    CHECK(std::abs(ink.xy - 9 * (a * c + b * d)) < 0.3);
    CHECK(std::abs(ink.yy - 9 * (c * c + d * d)) < 0.3);
  }
}

TEST_CASE("a dot is bent: what is inside is what came from inside") {
  const Vec2<double> centre(38, 31);
  const auto bend = [](const Vec2<double>& p) -> Vec2<double> {
    return {3 * std::sin(0.15 * p.y()), 2 * std::cos(0.2 * p.x())};
  };
  Image<Vec2<double>> everywhere(81, 61);
  for (Index y = 0; y < 61; ++y) {
    for (Index x = 0; x < 81; ++x) everywhere(x, y) = bend(Vec2<double>(x, y));
  }
  auto image = white(), sampled = white();
  const auto dot = one_dot(centre, 10);
  dot.draw_into(image, bend);
  dot.draw_into(sampled, everywhere);
  int wrong = 0, differing = 0;
  for (Index y = 0; y < 61; ++y) {
    for (Index x = 0; x < 81; ++x) {
      Vec2<double> from(x, y);
      for (int k = 0; k < 200; ++k) from += 0.5 * (Vec2<double>(x, y) - bend(from) - from);
      const double outside = (from - centre).norm() - 10;
      const double share = 1 - image(x, y)[0] / 255.0;
      if (std::abs(outside) > 1.5 && std::abs(share - (outside < 0 ? 1 : 0)) > 0.01) ++wrong;
      if (std::abs(image(x, y)[0] - sampled(x, y)[0]) > 12) ++differing;
    }
  }
  CHECK(wrong == 0);
  CHECK(differing == 0);
}

TEST_CASE("a slope foreshortens a dot") {
  // On the camera's axis, on a plane of slope s, a small disc's area shrinks by 1 / sqrt(1 + s^2).
  for (const double slope : {-1.5, -0.5, 0.0, 0.4, 2.0}) {
    Image<double> plane(81, 61);
    for (Index y = 0; y < 61; ++y) {
      // z = rest + slope X, X = z (x - cx) / fx.
      for (Index x = 0; x < 81; ++x) plane(x, y) = rest / (1 - slope * (x - 40) / 300.0);
    }
    const std::vector<Vec2<double>> centre{{40, 30}};
    auto image = white();
    PrintedDots(eye, plane, centre, 6 * rest / 300, black).draw_into(image);
    const Ink ink = ink_of(image);
    CHECK(ink.area == gelight::test::approx(36 * pi / std::sqrt(1 + slope * slope)).epsilon(0.03));
    CHECK(ink.xx == gelight::test::approx(9 / (1 + slope * slope)).epsilon(0.05));
    CHECK(ink.yy == gelight::test::approx(9).epsilon(0.05));
  }
}

TEST_CASE("dots of a gel that a ball presses and drags") {
  const double pitch = rest / 300;
  const ElasticLayer layer(eye, rest, {1e5, 0.48, 30 * pitch, 1});
  Image<double> depth(81, 61);
  for (Index y = 0; y < 61; ++y) {
    for (Index x = 0; x < 81; ++x) {
      const double r = std::hypot(x - 40, y - 30);
      depth(x, y) = rest - pitch * (3 - r * r / 60);
    }
  }
  const auto contact = layer.press(depth, {.shift = {4 * pitch, 0}});
  const auto moved = marker_displacement(eye, layer.rest_depth(), contact.displacement);
  const auto centres = dot_grid(5, 4, {10, 9}, {15, 14});
  REQUIRE(centres.size() == 20);
  CHECK(centres[6] == Vec2<double>(25, 23));
  const auto by =
      marker_displacement<double>(eye, layer.rest_depth(), contact.displacement, centres);
  const auto same = sample_markers<double>(moved, centres);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    CHECK((by[i] - same[i]).norm() < 1e-12);
    auto image = white();
    PrintedDots(eye, layer.rest_depth(), std::vector{centres[i]}, 2 * pitch, black)
        .draw_into(image, moved);
    // Its middle; the ink's differs by how the displacement is bent over two pixels.
    CHECK((ink_of(image).centre - centres[i] - by[i]).norm() < 0.15);
  }
  CHECK(by[6].x() + by[7].x() > 2);  // the middle is dragged along
}

TEST_CASE("ink takes a share of each channel; what is not known or seen is left out") {
  const Image<double> flat(81, 61, rest);
  const std::vector<Vec2<double>> centres{{40, 30}, {0, 0}, {80, 60}, {0, 60}};
  Image<Rgb8> image(81, 61, Rgb8{200, 100, 50});
  const PrintedDots dots(eye, flat, centres, 4 * rest / 300, {0.5, 0.25, 1});
  CHECK(dots.centres() == centres);
  dots.draw_into(image);
  CHECK(image(40, 30) == Rgb8{100, 25, 50});
  CHECK(image(0, 0) == Rgb8{100, 25, 50});
  CHECK(image(80, 60) == Rgb8{100, 25, 50});
  CHECK(image(20, 30) == Rgb8{200, 100, 50});
  const auto untouched = white();
  for (const double away : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e9, 100.0}) {
    auto same = untouched;
    dots.draw_into(same, [&](const Vec2<double>&) { return Vec2<double>(away, away); });
    CHECK(same == untouched);
  }
  // A view, of every other pixel upside down.
  Image<Rgb8> large(162, 122, Rgb8{200, 100, 50});
  dots.draw_into(ImageView<Rgb8>(&large(0, 120), 81, 61, -2 * 162, 2));
  for (Index y = 0; y < 61; ++y) {
    for (Index x = 0; x < 81; ++x) CHECK(large(2 * x, 120 - 2 * y) == image(x, y));
  }
}

TEST_CASE("a dot that reaches behind the camera is left out, whatever tells how it moves") {
  // A membrane so steep that a disc wider than it is deep ends behind the camera.
  Image<double> steep(81, 61);
  for (Index y = 0; y < 61; ++y) {
    for (Index x = 0; x < 81; ++x) steep(x, y) = rest / (1 + 2 * eye.ray(x, y).x());
  }
  const std::vector<Vec2<double>> centres{{40, 30}};
  const PrintedDots dots(eye, steep, centres, 2 * rest, black);
  auto image = white();
  dots.draw_into(image);
  dots.draw_into(image, Image<Vec2<double>>(81, 61, Vec2<double>(1, 2)));
  dots.draw_into(image, [](const Vec2<double>& pixel) {
    CHECK(pixel.allFinite());
    return Vec2<double>(1, 2);
  });
  CHECK(image == white());
}

TEST_CASE("a dot on a wall's far side is hidden, one on its near side is not") {
  // Hills towards the camera, which sees them from beside. A point of z = rest - h(x, y) is turned
  // away where its normal (-slope, 1) and the ray to it point apart from each other.
  const Camera<double> wide{100, 100, 100, 90, 201, 181};
  int hidden = 0;
  for (const Vec2<double>& top : {Vec2<double>(8e-3, 0), {-6e-3, 6e-3}, {0, -9e-3}}) {
    for (const double height : {1e-3, 5e-3, 12e-3}) {
      constexpr double width = 1e-3;
      const auto lifted = [&](const Vec2<double>& pixel) {
        Vec3<double> point = wide.unproject(pixel.x(), pixel.y(), rest);
        const double square = (point.head<2>() - top).squaredNorm();
        point.z() -= height * std::exp(-square / (2 * width * width));
        return point;
      };
      const auto field = [&](const Vec2<double>& pixel) {
        return Vec2<double>(wide.project(lifted(pixel)) - pixel);
      };
      const Vec2<double> middle = wide.project(Vec3<double>(top.x(), top.y(), rest));
      for (const auto& pixel : dot_grid(13, 13, middle - Vec2<double>(9, 9), {1.5, 1.5})) {
        const Vec3<double> point = wide.unproject(pixel.x(), pixel.y(), rest),
                           there = lifted(pixel);
        const Vec2<double> slope =
            (there.z() - rest) / (width * width) * (point.head<2>() - top) * -1;
        const double facing = (there.z() - slope.dot(there.head<2>())) / there.norm();
        if (std::abs(facing) < 0.3) continue;  // edge on
        auto image = white(201, 181);
        PrintedDots(wide, Image<double>(201, 181, rest), std::array{pixel}, 0.3 * rest / 100, black)
            .draw_into(image, field);
        CHECK((ink_of(image).area > 1e-3) == (facing > 0));
        hidden += facing < 0 ? 1 : 0;
      }
    }
  }
  CHECK(hidden > 20);
}

TEST_CASE("bad input is named") {
  const Image<double> flat(81, 61, rest);
  const std::vector<Vec2<double>> centres{{3, 4}, {40, 30}};
  const auto says = [&](const Image<double>& depth, const std::vector<Vec2<double>>& at,
                        double radius, double ink) {
    return refusal([&] { PrintedDots(eye, depth, at, radius, {0, ink, 0}); });
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(says(flat, centres, 1e-3, 0.5) == "accepted");
  CHECK(contains(says(Image<double>(81, 60, rest), centres, 1e-3, 0), "81 x 60"));
  CHECK(contains(says(flat, {{3, 4}, {81, 2}}, 1e-3, 0), "dot 1 at (81, 2)"));
  for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    CHECK(contains(says(flat, centres, bad, 0), "radius"));
  }
  for (const double bad : {-0.1, 1.1, nan}) CHECK(contains(says(flat, centres, 1e-3, bad), "ink"));
  auto holed = flat;
  holed(40, 31) = nan;
  CHECK(contains(says(holed, centres, 1e-3, 0), "dot 1 at (40, 30)"));
  const PrintedDots dots(eye, flat, centres, 1e-3);
  auto small = white(80, 61);
  CHECK(contains(refusal([&] { dots.draw_into(small); }), "80 x 61"));
  auto right = white();
  CHECK(contains(refusal([&] { dots.draw_into(right, Image<Vec2<double>>(81, 3)); }), "81 x 3"));
  CHECK(contains(refusal([&] { (void)dot_grid(-1, 2, {0, 0}, {1, 1}); }), "-1 x 2"));
  for (const auto& [across, down] : std::vector<std::array<Index, 2>>{
           {1 << 20, 1 << 20}, {4097, 4096}, {1, (1 << 24) + 1}, {(1 << 24) + 1, 1}}) {
    const Index columns = across, rows = down;  // clang++ 14 takes no binding into a lambda
    const std::string words = std::to_string(columns) + " x " + std::to_string(rows);
    CHECK(contains(refusal([&] { (void)dot_grid(columns, rows, {0, 0}, {1, 1}); }), words));
  }
  CHECK(dot_grid(1 << 30, 0, {0, 0}, {1, 1}).empty());
  CHECK(contains(refusal([&] {
                   (void)marker_displacement<double>(eye, flat, Image<Vec3<double>>(81, 61),
                                                     std::vector<Vec2<double>>{{-1, 0}});
                 }),
                 "marker 0"));
}
