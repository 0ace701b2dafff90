#include "gelight/membrane/drape.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

#include "gelight/image/raster.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/refusal.hpp"

using namespace gelight;

namespace {

/// The shortest way between two pixels in steps of 1, the roots of 2 and of 5, in closed form.
double way(Index across, Index down) {
  const double a = std::max(std::abs(across), std::abs(down));
  const double b = std::min(std::abs(across), std::abs(down));
  return 2 * b <= a ? std::sqrt(5.0) * b + a - 2 * b
                    : std::sqrt(5.0) * (a - b) + std::sqrt(2.0) * (2 * b - a);
}

template <class T>
T largest_step(const Image<T>& image, Index margin) {
  T most = 0;
  for (Index y = margin; y < image.height() - margin; ++y) {
    for (Index x = margin; x + 1 < image.width() - margin; ++x) {
      most = std::max(most, std::abs(image(x + 1, y) - image(x, y)));
    }
  }
  return most;
}

}  // namespace

TEST_CASE_TEMPLATE("gel hangs from every pixel by the way to it", T, float, double) {
  std::mt19937 random(7);
  for (const double unit : {1e-6, 1.0, 1e6}) {
    for (int seed = 0; seed < 5; ++seed) {
      std::uniform_real_distribution<double> uniform(0, 1);
      Image<T> depth(23, 17), rest(23, 17);
      for (T& z : rest.pixels()) z = static_cast<T>(unit * (20 + uniform(random)));
      for (T& z : depth.pixels()) {
        z = static_cast<T>(unit * (10 + 10 * uniform(random)));
        if (uniform(random) < 0.9) z = std::numeric_limits<T>::infinity();
      }
      const double fall = unit * (0.2 + uniform(random));
      const auto draped = drape(depth, rest, static_cast<T>(fall));
      for (Index y = 0; y < 17; ++y) {
        for (Index x = 0; x < 23; ++x) {
          double most = 0;
          for (Index v = 0; v < 17; ++v) {
            for (Index u = 0; u < 23; ++u) {
              if (depth(u, v) >= rest(u, v)) continue;
              const double there = double{rest(u, v)} - double{depth(u, v)};
              most = std::max(most, there - fall * way(x - u, y - v));
            }
          }
          const double own = std::max(0.0, double{rest(x, y)} - double{draped(x, y)});
          CHECK(own == doctest::Approx(most).epsilon(1e-4).scale(unit));
        }
      }
      // In place it is the same.
      Image<T> same = depth;
      drape_into(same, same, rest, static_cast<T>(fall));
      CHECK(same == draped);
      // Over the rest depth too; and over one that lies a row further on in the same memory.
      same = rest;
      drape_into(same, depth, same, static_cast<T>(fall));
      CHECK(same == draped);
      std::vector<T> memory(23 * 18);
      std::copy(rest.pixels().begin(), rest.pixels().end(), memory.begin() + 23);
      const ImageView<T> out(memory.data(), 23, 17);
      drape_into(out, depth, ImageView<const T>(memory.data() + 23, 23, 17), static_cast<T>(fall));
      CHECK(std::equal(draped.pixels().begin(), draped.pixels().end(), memory.begin()));
    }
  }
}

TEST_CASE("a ball past its middle leaves no step in the membrane, and one before is left alone") {
  const auto camera = Camera<double>::from_vertical_fov(0.7, 96, 72);
  const Image<double> rest(96, 72, 0.02);
  const double pixel = 0.02 / camera.fx, fall = 4 * pixel;
  for (const double radius : {0.002, 0.003, 0.004}) {
    for (const double share : {0.2, 0.4, 1.2, 1.5, 1.9}) {
      CAPTURE(radius);
      CAPTURE(share);
      const double deep = share * radius;
      const auto ball = placed<double>(icosphere<double>(5, radius), Eigen::Matrix3d::Identity(),
                                       {0, 0, 0.02 - deep + radius});
      const auto depth = rasterize(ball, camera).depth;
      const auto draped = drape(depth, rest, fall);
      const GaussianMembrane<double> membrane(3, 12);
      const auto before = surface_depth(membrane, depth, rest);
      const auto after = surface_depth(membrane, draped, rest);
      // Of what falls no faster, the Gaussian falls no faster; at the image's border its mean
      // lacks.
      CHECK(largest_step(after, 13) <= fall * 1.001);
      if (share < 0.5) CHECK(after == before);
      if (share >= 1.5) CHECK(largest_step(before, 13) > 1.2 * fall);
    }
  }
}

TEST_CASE("what is written may lie anywhere over the depth map and the rest depth") {
  constexpr Index size = 11, count = size * size;
  using View = ImageView<double>;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  std::vector<double> before(3 * count);
  for (double& z : before) z = uniform(random);
  // Packed, moved by a pixel and by a row, transposed, and turned by half a turn.
  const auto views = [](std::vector<double>& memory) {
    double* const first = memory.data() + count;
    return std::vector{View(first, size, size),
                       View(first + 1, size, size),
                       View(first - 1, size, size),
                       View(first + size, size, size),
                       View(first, size, size).transposed(),
                       View(first + count - 1, size, size, -size, -1)};
  };
  const std::size_t all = views(before).size();
  for (std::size_t i = 0; i < all; ++i) {
    for (std::size_t j = 0; j < all; ++j) {
      for (std::size_t k = 0; k < all; ++k) {
        CAPTURE(i);
        CAPTURE(j);
        CAPTURE(k);
        auto apart = before;
        const auto expected = drape(views(before)[j], views(apart)[k], 0.07);
        auto memory = before;
        const auto over = views(memory);
        drape_into(over[i], over[j], over[k], 0.07);
        bool is_same = true;
        for (Index y = 0; y < size; ++y) {
          for (Index x = 0; x < size; ++x) is_same = is_same && over[i](x, y) == expected(x, y);
        }
        CHECK(is_same);
      }
    }
  }
}

TEST_CASE("what is not known stays so, and bad input is refused before anything is written") {
  const Image<float> rest(9, 9, 1.0f);
  Image<float> depth(9, 9, std::numeric_limits<float>::infinity());
  depth(4, 4) = 0.5f;
  depth(5, 4) = 0;
  depth(4, 5) = std::numeric_limits<float>::quiet_NaN();
  const auto draped = drape(depth, rest, 0.1f);
  CHECK(draped(5, 4) == 0);
  CHECK(std::isnan(draped(4, 5)));
  CHECK(draped(3, 4) == doctest::Approx(0.6f));
  Image<float> out(9, 9, 7.0f);
  for (const float fall : {0.0f, -1.0f, std::numeric_limits<float>::infinity(),
                           std::numeric_limits<float>::quiet_NaN()}) {
    CHECK(test::refusal([&] { drape_into(out, depth, rest, fall); }).find("a fall of") == 0);
  }
  CHECK_THROWS_AS(drape_into(out, depth, Image<float>(9, 8), 0.1f), InvalidInput);
  CHECK(out == Image<float>(9, 9, 7.0f));
}
