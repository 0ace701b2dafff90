// One meaning of depth (image/mask.hpp) in every function that takes a depth image: +infinity,
// where nothing is; NaN, zero and negative, where it is not known.

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/plane_fit.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/membrane/elastic.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/see_through.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

using namespace gelight;

namespace {

constexpr Index width = 83, height = 61;

/// What a function makes of a pixel, as three numbers.
using Picture = Image<std::array<double, 3>>;

/// What stands at a pixel whose depth is not known.
enum class Stays : std::uint8_t { nan, zero, ambient, as_if_nothing_touched };

template <class T>
struct Taker {
  std::string name;
  std::function<Picture(const Image<T>& depth, const Image<T>& rest)> of;
  Stays stays;
  bool has_rest = true;  ///< what is not there is as at rest; otherwise there is no surface
  Index beside = 0;      ///< pixels around one that is not known which its window holds
};

template <class T>
Camera<T> camera() {
  return {T(70), T(72), T(41.2), T(30.4), width, height};
}

template <class T>
Image<T> curved_rest() {
  Image<T> rest(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      rest(x, y) = static_cast<T>(0.03 + 2e-5 * x - 1e-5 * y + 1e-6 * (x - 30) * (x - 30));
    }
  }
  return rest;
}

template <class T>
std::vector<Light<T>> lights() {
  const auto along = [](double x, double y, double z) {
    return Image<Vec3<T>>(width, height, Vec3<double>(x, y, z).normalized().cast<T>());
  };
  return {{along(1, 0.2, 0.1), {1, T(0.4), 0}},
          {along(-0.3, -1, 0.4), {0, T(0.2), 1}, T(0.5), T(0.3), 7}};
}

Picture picture(Index w, Index h, const auto& at) {
  Picture result(w, h);
  for (Index y = 0; y < h; ++y) {
    for (Index x = 0; x < w; ++x) result(x, y) = at(x, y);
  }
  return result;
}

Picture picture(const auto& image) {
  return picture(image.width(), image.height(), [&](Index x, Index y) -> std::array<double, 3> {
    const auto& p = image(x, y);
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(p)>>) {
      return {double(p), 0, 0};
    } else {
      return {double(p[0]), double(p[1]), double(p[2])};
    }
  });
}

Image<double> flat_gelsight(const Image<double>& depth) {
  return surface_depth(FlatGelSightMembrane<double>(), depth, Image<double>(width, height, 0.03));
}

template <class T>
std::vector<Taker<T>> takers() {
  using I = Image<T>;
  const Camera<T> eye = camera<T>();
  const std::array<double, 3> sigmas{4, 2, 1};
  std::vector<Taker<T>> all{
      {"unproject", [=](const I& d, const I&) { return picture(unproject(d, eye)); }, Stays::nan,
       false},
      {"sobel_normals", [=](const I& d, const I&) { return picture(sobel_normals(d, eye)); },
       Stays::zero, false, 1},
      {"sobel_normals, extrapolated",
       [=](const I& d, const I&) {
         return picture(sobel_normals(d, eye, BorderNormals::extrapolated));
       },
       Stays::zero, false, 2},
      {"central_normals", [=](const I& d, const I&) { return picture(central_normals(d, eye)); },
       Stays::zero, false, 1},
      {"plane_fit_normals",
       [=](const I& d, const I&) { return picture(plane_fit_normals(d, eye, 2)); }, Stays::zero,
       false, 2},
      {"elastic_depth", [](const I& d, const I& r) { return picture(elastic_depth(d, r)); },
       Stays::nan},
      {"Taxim's membrane",
       [=](const I& d, const I& r) {
         return picture(surface_depth(PyramidMembrane<T>(sigmas), d, r));
       },
       Stays::nan},
      {"a shadowed membrane",
       [=](const I& d, const I& r) {
         const ShadowedMembrane<T> membrane(eye, GaussianMembrane<T>());
         return picture(surface_depth(membrane, d, r));
       },
       Stays::nan},
  };
  const auto add_renderer = [&](const std::string& what, const TactileOptions& options) {
    all.push_back({"TactileRenderer, " + what,
                   [=](const I& d, const I& r) {
                     const TactileRenderer<T> renderer(eye, r, lights<T>(),
                                                       std::array{T(0.5), T(0.3), T(0.7)}, options);
                     const auto image = renderer.render(d);
                     auto frame = renderer.rest_frame();
                     renderer.render_next_into(frame, d);
                     CHECK(frame.image == image);
                     return picture(image);
                   },
                   Stays::ambient, true, 1});
  };
  add_renderer("plain", {});
  add_renderer("every pixel", {.skip_unchanged = false});
  add_renderer("rectified", {.rectify = true});
  add_renderer("sigma 0", {.smoothing_sigma = 0});
  add_renderer("that pulls", {.clip_to_rest = false});
  add_renderer("sigma 0 that pulls", {.smoothing_sigma = 0, .clip_to_rest = false});
  add_renderer("as published", TactileOptions::as_published(true));
  add_renderer("darkening", {.darkening = 0.4, .darkening_depth = 0.002});
  add_renderer("extrapolated", {.border_normals = BorderNormals::extrapolated});
  all.push_back({"TactileRenderer, Taxim's membrane",
                 [=](const I& d, const I& r) {
                   const PhongLights<T> phong{lights<T>(), std::array{T(0.5), T(0.3), T(0.7)}};
                   return picture(
                       TactileRenderer(eye, r, PyramidMembrane<T>(sigmas), phong).render(d));
                 },
                 Stays::ambient, true, 1});
  all.push_back({"SeeThroughRenderer",
                 [=](const I& d, const I& r) {
                   const SeeThroughRenderer<T> renderer(
                       eye, r, edge_lights(eye, 0.3), std::array{T(0.5), T(0.3), T(0.7)},
                       {.thickness = 0.004, .ambient = 0.3, .exposure = 1});
                   return picture(renderer.render(d));
                 },
                 Stays::ambient, true, 2});
  return all;
}

// Unknown pixels of these renderers, by hand: ambient light on the background.
std::array<double, 3> ambient_of(const std::string& name) {
  const std::array<double, 3> background{0.5, 0.3, 0.7};
  // 255 share background, truncated; the see-through membrane reflects a half of it at half light.
  const double share = name == "SeeThroughRenderer" ? 0.3 * 0.5 * 0.5 : 0.5;
  std::array<double, 3> seen{};
  for (std::size_t c = 0; c < 3; ++c) seen[c] = std::floor(255 * share * background[c] + 1e-4);
  return seen;
}

bool is_same(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (!(a[c] == b[c] || (std::isnan(a[c]) && std::isnan(b[c])))) return false;
  }
  return true;
}

int differing(const Picture& a, const Picture& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    count += is_same(a.pixels()[i], b.pixels()[i]) ? 0 : 1;
  }
  return count;
}

/// Marks a few rectangles of pixels, some at the border.
Image<std::uint8_t> patches(std::mt19937& random) {
  Image<std::uint8_t> marks(width, height);
  for (int k = 0; k < 4; ++k) {
    const auto below = [&](Index most) { return static_cast<Index>(random() % unsigned(most)); };
    const Index left = below(width + 4) - 4, top = below(height + 4) - 4;
    const Index right = left + 1 + below(9), bottom = top + 1 + below(9);
    for (Index y = std::max(0, top); y < std::min(height, bottom); ++y) {
      for (Index x = std::max(0, left); x < std::min(width, right); ++x) marks(x, y) = 1;
    }
  }
  return marks;
}

/// A rough object that touches here and there.
template <class T>
Image<T> pressed(const Image<T>& rest, std::mt19937& random) {
  Image<T> depth = rest;
  std::uniform_real_distribution<double> at(0, 1);
  for (int k = 0; k < 3; ++k) {
    const double u = at(random) * width, v = at(random) * height, r = 4 + 12 * at(random);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double inside = 1 - ((x - u) * (x - u) + (y - v) * (y - v)) / (r * r);
        if (inside > 0) depth(x, y) -= static_cast<T>(0.002 * inside * (0.9 + 0.1 * at(random)));
      }
    }
  }
  return depth;
}

template <class T>
Image<T> with(Image<T> depth, const Image<std::uint8_t>& marks, const auto& value) {
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if (marks(x, y) != 0) depth(x, y) = value(x, y);
    }
  }
  return depth;
}

bool is_near(const Image<std::uint8_t>& marks, Index x, Index y, Index reach) {
  for (Index v = std::max(0, y - reach); v <= std::min(height - 1, y + reach); ++v) {
    for (Index u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u) {
      if (marks(u, v) != 0) return true;
    }
  }
  return false;
}

template <class T>
std::vector<T> unknown_depths() {
  using L = std::numeric_limits<T>;
  return {L::quiet_NaN(), T(0), T(-0.0), T(-1), -L::infinity(), -L::denorm_min(), T(-1e30)};
}

template <class T>
constexpr T inf = std::numeric_limits<T>::infinity();

}  // namespace

TEST_CASE_TEMPLATE("where nothing is, nothing touches, or there is no surface", T, float, double) {
  const Image<T> rest = curved_rest<T>();
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 random(seed);
    const auto depth = pressed(rest, random);
    const auto marks = patches(random);
    const auto nothing = with(depth, marks, [](Index, Index) { return inf<T>; });
    const auto resting = with(depth, marks, [&](Index x, Index y) { return rest(x, y); });
    const auto unknown =
        with(depth, marks, [](Index, Index) { return std::numeric_limits<T>::quiet_NaN(); });
    for (const auto& taker : takers<T>()) {
      CAPTURE(taker.name);
      const auto& same = taker.has_rest ? resting : unknown;
      CHECK(differing(taker.of(nothing, rest), taker.of(same, rest)) == 0);
      if (!taker.has_rest) continue;
      const Image<T> empty(width, height, inf<T>);
      CHECK(differing(taker.of(empty, rest), taker.of(rest, rest)) == 0);
    }
  }
}

TEST_CASE_TEMPLATE("what is not known stays so, however it is written, and does not spread", T,
                   float, double) {
  const Image<T> rest = curved_rest<T>();
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 random(seed);
    const auto depth = pressed(rest, random);
    const auto marks = patches(random);
    for (const auto& taker : takers<T>()) {
      CAPTURE(taker.name);
      Picture first;
      const auto untouched =
          taker.of(with(depth, marks, [&](Index x, Index y) { return rest(x, y); }), rest);
      const auto at_rest = taker.of(rest, rest);
      for (const T value : unknown_depths<T>()) {
        CAPTURE(value);
        const auto fill = [&](Index, Index) { return value; };
        const auto made = taker.of(with(depth, marks, fill), rest);
        if (first.width() == 0) first = made;
        CHECK(differing(made, first) == 0);
        // On a membrane at rest there is nothing to be averaged: all but the pixels is as it was.
        const auto holed = taker.of(with(rest, marks, fill), rest);
        int lost = 0, spread = 0;
        for (Index y = 0; y < height; ++y) {
          for (Index x = 0; x < width; ++x) {
            const auto there = made(x, y);
            if (marks(x, y) != 0) {
              auto want =
                  taker.stays == Stays::ambient ? ambient_of(taker.name) : std::array<double, 3>{};
              if (taker.stays == Stays::as_if_nothing_touched) want = untouched(x, y);
              const bool stays =
                  taker.stays == Stays::nan ? std::isnan(there[0]) : is_same(there, want);
              lost += stays ? 0 : 1;
            } else if (!is_near(marks, x, y, taker.beside)) {
              spread += is_same(holed(x, y), at_rest(x, y)) ? 0 : 1;
            }
          }
        }
        CHECK(lost == 0);
        CHECK(spread == 0);
      }
    }
  }
}

TEST_CASE_TEMPLATE("a membrane is masked alike by every depth that is none", T, float, double) {
  const Image<T> rest = curved_rest<T>();
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 random(seed);
    const auto depth = pressed(rest, random);
    auto marks = patches(random);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        if (std::hypot(x - 41, y - 30) > 34) marks(x, y) = 1;
      }
    }
    auto values = unknown_depths<T>();
    values.push_back(inf<T>);
    for (const auto& taker : takers<T>()) {
      if (!taker.has_rest) continue;
      CAPTURE(taker.name);
      Picture first, first_in_depth;
      for (const T value : values) {
        CAPTURE(value);
        const auto fill = [&](Index, Index) { return value; };
        const auto membrane = with(rest, marks, fill);
        const auto made = taker.of(depth, membrane);
        if (first.width() == 0) first = made;
        CHECK(differing(made, first) == 0);
        // The object's depth out there does not matter.
        const auto masked = taker.of(with(depth, marks, fill), membrane);
        CHECK(differing(masked, first) == 0);
      }
    }
  }
}

TEST_CASE_TEMPLATE("springs: no object where nothing is, nor where it is not known", T, float,
                   double) {
  const Camera<T> eye = camera<T>();
  for (const double tension : {0.0, 0.3}) {
    const SpringBed<T> bed(eye, T(0.03), {.elastic_modulus = 1e5, .tension = tension});
    for (unsigned seed = 0; seed < 3; ++seed) {
      std::mt19937 random(seed);
      const auto depth = pressed(Image<T>(width, height, T(0.031)), random);
      const auto marks = patches(random);
      const auto press = [&](const Image<T>& image) { return bed.press(image, 0.5); };
      const auto far = press(with(depth, marks, [](Index, Index) { return T(1e3); }));
      const auto nothing = press(with(depth, marks, [](Index, Index) { return inf<T>; }));
      REQUIRE(far.equilibrium == Equilibrium::reached);
      CHECK(nothing.displacement == far.displacement);
      CHECK(nothing.indentation == far.indentation);
      CHECK(nothing.unknown == 0);
      for (const T value : unknown_depths<T>()) {
        const auto contact = press(with(depth, marks, [&](Index, Index) { return value; }));
        CHECK(contact.displacement == far.displacement);
        const auto surface = bed.depth(contact);
        int wrong = 0, count = 0;
        for (Index y = 0; y < height; ++y) {
          for (Index x = 0; x < width; ++x) {
            count += marks(x, y);
            const bool stays = std::isnan(contact.indentation(x, y)) && std::isnan(surface(x, y));
            const bool same = contact.indentation(x, y) == far.indentation(x, y);
            wrong += (marks(x, y) != 0 ? stays : same) ? 0 : 1;
          }
        }
        CHECK(wrong == 0);
        CHECK(contact.unknown == count);
      }
    }
  }
}

TEST_CASE("the flat GelSight's membrane") {
  const Image<double> rest(width, height, 0.03);
  for (unsigned seed = 0; seed < 3; ++seed) {
    std::mt19937 random(seed);
    const auto depth = pressed(rest, random);
    const auto marks = patches(random);
    const auto whole = flat_gelsight(with(depth, marks, [](Index, Index) { return 0.03; }));
    CHECK(flat_gelsight(with(depth, marks, [](Index, Index) { return inf<double>; })) == whole);
    CHECK(flat_gelsight(Image<double>(width, height, inf<double>)) == rest);
    // Deeper than the gel nothing touches it.
    CHECK(flat_gelsight(with(depth, marks, [](Index, Index) { return 0.5; })) == whole);
    for (const double value : unknown_depths<double>()) {
      const auto fill = [&](Index, Index) { return value; };
      const auto holed = flat_gelsight(with(rest, marks, fill));
      const auto made = flat_gelsight(with(depth, marks, fill));
      // Pressed in evenly, the mean over those that are known is even, too.
      const auto even = flat_gelsight(with(Image<double>(width, height, 0.028), marks, fill));
      int wrong = 0;
      for (Index y = 0; y < height; ++y) {
        for (Index x = 0; x < width; ++x) {
          if (marks(x, y) != 0) {
            wrong += std::isnan(holed(x, y)) && std::isnan(made(x, y)) ? 0 : 1;
          } else {
            wrong += holed(x, y) == 0.03 && std::isfinite(made(x, y)) &&
                             std::abs(even(x, y) - 0.028) < 1e-12
                         ? 0
                         : 1;
          }
        }
      }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("an elastic membrane is averaged over what is known: pressed in evenly it stays even") {
  const auto rest = curved_rest<double>();
  Image<double> even = rest;
  for (double& z : even.pixels()) z -= 0.002;
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 random(seed);
    const auto marks = patches(random);
    const auto holed = with(even, marks, [](Index, Index) { return 0.0; });
    const auto masked = with(rest, marks, [](Index, Index) { return 0.0; });
    for (const auto& membrane :
         {elastic_depth(holed, rest), elastic_depth(even, masked),
          surface_depth(PyramidMembrane<double>(std::array{5.0, 2.0}), holed, rest)}) {
      double worst = 0;
      for (std::size_t i = 0; i < marks.pixels().size(); ++i) {
        if (marks.pixels()[i] != 0) continue;
        worst = std::max(worst, std::abs(membrane.pixels()[i] - even.pixels()[i]));
      }
      CHECK(worst < 1e-15);
    }
  }
}

TEST_CASE_TEMPLATE("an object as rasterize sees it, pressed into a membrane", T, float, double) {
  const Camera<T> eye = camera<T>();
  const Image<T> rest = curved_rest<T>();
  for (const double aside : {-0.01, 0.0, 0.004, 0.5}) {
    auto ball = icosphere<T>(3);
    for (auto& p : ball.positions) {
      for (auto& x : p) x *= T(0.004);
      p[0] += static_cast<T>(aside);
      p[2] += T(0.0325);
    }
    const Image<T> seen = rasterize(ball, eye).depth;
    Image<T> by_hand = seen;
    for (std::size_t i = 0; i < rest.pixels().size(); ++i) {
      by_hand.pixels()[i] = std::min(seen.pixels()[i], rest.pixels()[i]);
    }
    for (const bool rectify : {false, true}) {
      for (const bool skip : {false, true}) {
        const TactileRenderer<T> renderer(eye, rest, lights<T>(), std::array{T(1), T(1), T(1)},
                                          {.rectify = rectify, .skip_unchanged = skip});
        CHECK(renderer.render(seen) == renderer.render(by_hand));
        CHECK((renderer.render(seen) == renderer.rest_image()) == (aside == 0.5));
      }
    }
    CHECK(elastic_depth(seen, rest) == elastic_depth(by_hand, rest));
  }
}
