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
#include "support/approx.hpp"
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
          CHECK(own == gelight::test::approx(most).epsilon(1e-4).scale(unit));
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

TEST_CASE_TEMPLATE("gel hangs around what is not known, however often the way turns back", T, float,
                   double) {
  // Two pixels of walls that reach from either side to before the other, in turn; then holes
  // anywhere.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int seed = 0; seed < 8; ++seed) {
    const Index width = 19, height = 26;
    Image<T> rest(width, height, T(1)), depth(width, height, std::numeric_limits<T>::infinity());
    const auto hole = std::numeric_limits<T>::quiet_NaN();
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const bool is_wall = y % 6 > 3 && (y / 6 % 2 == 0 ? x < width - 2 : x > 1);
        if (seed == 0 ? is_wall : uniform(random) < 0.4)
          (seed % 2 == 0 ? depth : rest)(x, y) = hole;
      }
    }
    depth(0, 0) = T(0.5);
    rest(0, 0) = 1;
    const T fall = T(1) / 512;
    const auto draped = drape(depth, rest, fall);
    // The protrusions that no step of the sixteen raises, beginning with the object's.
    Image<double> truth(width, height, 0);
    const auto is_known = [&](Index x, Index y) { return depth(x, y) > 0 && rest(x, y) > 0; };
    truth(0, 0) = 0.5;
    for (bool rose = true; rose;) {
      rose = false;
      for (Index y = 0; y < height; ++y) {
        for (Index x = 0; x < width; ++x) {
          for (Index v = std::max(0, y - 2); v <= std::min(height - 1, y + 2); ++v) {
            for (Index u = std::max(0, x - 2); u <= std::min(width - 1, x + 2); ++u) {
              const Index square = (u - x) * (u - x) + (v - y) * (v - y);
              const bool is_step = square == 1 || square == 2 || square == 5;
              if (!is_step || !is_known(x, y) || !is_known(u, v)) continue;
              const double there = truth(u, v) - double{fall} * std::sqrt(double(square));
              if (there <= truth(x, y) + 1e-9) continue;
              truth(x, y) = there;
              rose = true;
            }
          }
        }
      }
    }
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        if (!is_known(x, y)) {
          CHECK((draped(x, y) == depth(x, y) || std::isnan(draped(x, y))));
          continue;
        }
        const double own = std::max(0.0, double{rest(x, y)} - double{draped(x, y)});
        CHECK(own == gelight::test::approx(truth(x, y)).epsilon(1e-5).scale(1));
      }
    }
  }
}

TEST_CASE("gel beside a higher protrusion than itself is deep stays before the camera") {
  Image<double> rest(6, 1, 1.0), depth(6, 1, std::numeric_limits<double>::infinity());
  depth(0, 0) = 0.1;
  rest(1, 0) = rest(2, 0) = 0.01;
  const auto draped = drape(depth, rest, 1e-3);
  for (const double z : draped.pixels()) CHECK(z > 0);
  CHECK(draped(2, 0) < 1e-3);
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
  CHECK(draped(3, 4) == gelight::test::approx(0.6f));
  Image<float> out(9, 9, 7.0f);
  for (const float fall : {0.0f, -1.0f, std::numeric_limits<float>::infinity(),
                           std::numeric_limits<float>::quiet_NaN()}) {
    CHECK(test::refusal([&] { drape_into(out, depth, rest, fall); }).find("a fall of") == 0);
  }
  CHECK_THROWS_AS(drape_into(out, depth, Image<float>(9, 8), 0.1f), InvalidInput);
  CHECK(out == Image<float>(9, 9, 7.0f));
}
