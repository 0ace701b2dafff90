#include "gelight/membrane/bulge.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/elastic.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/layer_membrane.hpp"
#include "support/approx.hpp"
#include "support/dense.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::contains;
using test::refusal;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double rest = 0.03;

using Overlap = std::function<double(double, double)>;

// Pixels `pitch` apart, counted from the middle.
Camera<double> camera(Index width, Index height, double pitch) {
  const double f = rest / pitch;
  return {f, f, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
}

// What stands `overlap(x, y)` past the gel, all in pixels.
Image<double> object(const Camera<double>& eye, const Overlap& overlap) {
  Image<double> depth(eye.width, eye.height);
  for (Index v = 0; v < eye.height; ++v) {
    for (Index u = 0; u < eye.width; ++u) {
      depth(u, v) = rest * (1 - overlap(u - eye.cx, v - eye.cy) / eye.fx);
    }
  }
  return depth;
}

Overlap ball(double radius, double press, double x0 = 0, double y0 = 0) {
  return [=](double x, double y) {
    const double r2 = (x - x0) * (x - x0) + (y - y0) * (y - y0);
    return press * (1 - r2 / (2 * radius * radius));
  };
}

// Mean angle between two surfaces' normals, in degrees, within `reach` pixels of the middle.
double normals_off(const Image<double>& a, const Image<double>& b, double pitch, double reach) {
  const auto normal = [&](const Image<double>& z, Index x, Index y) {
    return Vec3<double>((z(x + 1, y) - z(x - 1, y)) / (2 * pitch),
                        (z(x, y + 1) - z(x, y - 1)) / (2 * pitch), 1)
        .normalized();
  };
  double sum = 0;
  int count = 0;
  for (Index y = 1; y + 1 < a.height(); ++y) {
    for (Index x = 1; x + 1 < a.width(); ++x) {
      if (std::hypot(x - (a.width() - 1) / 2.0, y - (a.height() - 1) / 2.0) > reach) continue;
      const Vec3<double> p = normal(a, x, y), q = normal(b, x, y);
      const Vec3<double> across(p.y() * q.z() - p.z() * q.y(), p.z() * q.x() - p.x() * q.z(),
                                p.x() * q.y() - p.y() * q.x());
      sum += std::asin(std::min(1.0, across.norm())) * 180 / std::numbers::pi;
      ++count;
    }
  }
  return sum / count;
}

// Of the Gaussian whose normals are nearest, which nobody knows beforehand.
double best_gaussian(const Image<double>& depth, const Image<double>& gel,
                     const Image<double>& truth, double pitch, double reach) {
  double best = inf;
  for (double sigma = 0.8; sigma < reach / 2; sigma *= 1.4) {
    const auto radius = static_cast<Index>(std::ceil(3 * sigma));
    best =
        std::min(best, normals_off(elastic_depth(depth, gel, sigma, radius), truth, pitch, reach));
  }
  return best;
}

}  // namespace

TEST_CASE("a sum of products is the function itself, or as near as so few can be") {
  for (const auto& [width, height] : {std::pair{9, 14}, {30, 23}}) {
    const detail::LayerGrid grid{width, height, 1.1, 6.3, 0.48};
    const detail::PressureGreen green(grid, detail::layer_correction(grid));
    Eigen::MatrixXd matrix(height, width);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) matrix(y, x) = green.down(x, y);
    }
    const DenseVector<double> singular = singular_values(matrix);
    for (const int terms : {1, 2, 3, 5, 100}) {
      const detail::SeparableKernel<double> kernel(
          width, height, terms, [&](Index x, Index y) { return green.down(x, y); });
      double square = 0, uneven = 0;
      for (Index y = 0; y < height; ++y) {
        for (Index x = 0; x < width; ++x) {
          double sum = 0, mirrored = 0;
          for (std::size_t k = 0; k < kernel.terms(); ++k) {
            sum += kernel.across(k, 0)[x] * kernel.down(k, y);
            mirrored += kernel.across(k, x)[0] * kernel.down(k, -y);
          }
          square += (sum - matrix(y, x)) * (sum - matrix(y, x));
          uneven = std::max(uneven, std::abs(sum - mirrored));
        }
      }
      const auto left = std::max<Eigen::Index>(0, singular.size() - terms);
      // Eckart and Young's theorem.
      CHECK(std::sqrt(square) <= 1.02 * singular.tail(left).norm() + 1e-8 * singular[0]);
      CHECK(uneven < 1e-15);
    }
  }
}

TEST_CASE("pressures on a coarse grid bear and never pull, and the gel is not in the object") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> bump(0, 1);
  for (const double nu : {0.2, 0.5}) {
    for (const double thickness : {20.0, inf}) {
      const detail::LayerGrid pixels{96, 80, 1, thickness, nu};
      const detail::CoarseLayer<double> layer(pixels, 4, 100);
      const detail::Cells box{3, 2, 18, 16};
      detail::CoarseContact<double> contact(box.area());
      for (std::size_t i = 0; i < box.area(); ++i) {
        const double x = static_cast<double>(i % 18) - 8, y = static_cast<double>(i / 18) - 7.5;
        contact.wanted[i] =
            bump(random) < 0.1 ? -inf : 1 - 0.03 * (x * x + y * y) + 0.1 * bump(random);
      }
      std::vector<double> part(box.area()), down(box.area());
      CHECK(contact.solve(layer, box, 1e-6, 500, part.data()));
      layer.sink(down.data(), box, contact.pressure.data(), box, part.data());
      int bearing = 0;
      for (std::size_t i = 0; i < box.area(); ++i) {
        CHECK(contact.pressure[i] >= 0);
        const double gap = down[i] - contact.wanted[i];
        CHECK(gap > -2e-6);
        if (contact.pressure[i] * layer.softness() > 2e-6) {
          CHECK(gap < 2e-6);
          ++bearing;
        }
      }
      CHECK(bearing > 20);
    }
  }
}

TEST_CASE("normals at least twice as near to the converged layer's as any Gaussian's") {
  struct Shape {
    std::string name;
    double radius;
    Overlap overlap;
  };
  const auto two = [](double x, double y) {
    return std::max(ball(13, 4, -19, 3)(x, y), ball(13, 4, 20, -2)(x, y));
  };
  const auto ribbed = [](double x, double y) {
    return ball(30, 3)(x, y) + 0.5 * std::cos((x + 0.3 * y) / 2.5);
  };
  const Shape shapes[] = {{"ball", 30, ball(30, 3, 2.3, -1.1)},
                          {"small ball", 11, ball(11, 2, 0.4, 0.2)},
                          {"two points", 13, two},
                          {"grating", 30, ribbed}};
  for (const double pitch : {1e-4, 3e-5}) {
    const auto eye = camera(181, 161, pitch);
    const Image<double> gel_at_rest(181, 161, rest);
    for (const double nu : {0.3, 0.45, 0.5}) {
      if ((pitch < 1e-4) != (nu == 0.45)) continue;
      for (const double share : {0.5, 1.0, 4.0, inf}) {
        if (share == inf && nu != 0.3) continue;  // all the same
        // In a compressible gel that is no thicker than a few cells a Gaussian may be nearer.
        if (share == 0.5 && nu == 0.3) continue;
        for (const Shape& shape : shapes) {
          const Gel gel{1e5, nu, share * shape.radius * pitch};
          const auto depth = object(eye, shape.overlap);
          const auto truth =
              ElasticLayer(eye, rest, gel, {.tolerance = 5e-4, .sideways = false}).press(depth);
          REQUIRE(truth.converged);
          const double reach = std::min(80.0, 2.5 * shape.radius);
          const BulgingMembrane<double> membrane(eye, rest, gel);
          const double off =
              normals_off(membrane.depth(depth, gel_at_rest), truth.depth, pitch, reach);
          const double gaussian = best_gaussian(depth, gel_at_rest, truth.depth, pitch, reach);
          CAPTURE(shape.name);
          CAPTURE(nu);
          CAPTURE(share);
          const bool is_hard = nu == 0.3 && share == 1;
          CHECK(off < (is_hard ? 0.75 : 0.5) * gaussian);
        }
      }
    }
  }
}

TEST_CASE("which Gaussian stands for which gel: nearly the best there is") {
  const double pitch = 1e-4, radius = 30;
  const auto eye = camera(181, 181, pitch);
  const Image<double> gel_at_rest(181, 181, rest);
  const auto depth = object(eye, ball(radius, 3));
  for (const double nu : {0.2, 0.3, 0.49}) {
    for (const double share : {0.4, 0.8, 2.0, inf}) {
      const Gel gel{1e5, nu, share * radius * pitch};
      const auto truth = ElasticLayer(eye, rest, gel, {.sideways = false}).press(depth);
      const double best = best_gaussian(depth, gel_at_rest, truth.depth, pitch, 75);
      const double sigma = gaussian_sigma(gel, radius * pitch) / pitch;
      const auto cut = static_cast<Index>(std::ceil(4 * sigma));
      const double off =
          normals_off(elastic_depth(depth, gel_at_rest, sigma, cut), truth.depth, pitch, 75);
      CAPTURE(nu);
      CAPTURE(share);
      CHECK(off < best + 0.04);
    }
  }
  CHECK(contains(refusal([] { return gaussian_sigma(Gel{}, 0); }), "contact radius 0"));
  CHECK(contains(refusal([] { return gaussian_sigma({.thickness = -1}, 1); }), "thickness -1"));
  CHECK(contains(refusal([] { return gaussian_sigma({.poisson_ratio = 0.75}, 1); }), "0.75"));
}

TEST_CASE("a thin gel that keeps its volume rises around a ball, a half-space sinks") {
  const auto eye = camera(241, 201, 1e-4);
  const Image<double> gel_at_rest(241, 201, rest);
  const auto depth = object(eye, ball(20, 3));
  const auto at = [&](double nu, double thickness) {
    const BulgingMembrane<double> membrane(eye, rest, {1e5, nu, thickness * 1e-4});
    const auto surface = membrane.depth(depth, gel_at_rest);
    return (rest - surface(120 + 34, 100)) / 3e-4;  // sunk, of the press
  };
  CHECK(at(0.5, 15) < -0.05);
  // Beside a ball a half-space is sunk by Hertz: with s = r / a,
  // ((2 - s^2) asin(1 / s) + sqrt(s^2 - 1)) / pi of the press.
  const double s = 34.0 / 20;
  const double hertz = ((2 - s * s) * std::asin(1 / s) + std::sqrt(s * s - 1)) / std::numbers::pi;
  CHECK(at(0.3, inf) == gelight::test::approx(hertz).epsilon(0.08));
  CHECK(at(0.5, inf) == gelight::test::approx(at(0, inf)).epsilon(1e-9));
}

TEST_CASE(
    "a block's plate on the gel that rises beside it is felt, at no Poisson ratio of a sudden") {
  // The plate hangs 1 um above the gel at rest: only a gel that rises touches it.
  const auto eye = camera(121, 101, 1e-4);
  const Image<double> gel_at_rest(121, 101, rest);
  constexpr double press = 2e-4;
  const auto depth = object(eye, [](double x, double y) {
    return std::max(std::abs(x), std::abs(y)) < 20 ? -press : 1e-6;
  });
  // (Where one would change one's mind: at round numbers.)
  const std::vector percents{1, 5, 10, 15, 20, 24, 25, 26, 30, 33, 35, 40, 45, 48, 49};
  for (const double thickness : {3e-4, 8e-4}) {
    for (const int percent : percents) {
      const auto at = [&](double nu) {
        return BulgingMembrane<double>(eye, rest, {1e5, nu, thickness}).depth(depth, gel_at_rest);
      };
      const auto before = at(percent / 100.0), after = at(percent / 100.0 + 1e-9);
      double jump = 0;
      for (std::size_t i = 0; i < before.pixels().size(); ++i) {
        jump = std::max(jump, std::abs(after.pixels()[i] - before.pixels()[i]));
      }
      CAPTURE(percent);
      CHECK(jump < 0.013 * press);
    }
  }
}

TEST_CASE("the same bits whatever the window, and whatever was pressed before") {
  const auto eye = camera(150, 110, 1e-4).cast<float>();
  const BulgingMembrane<float> membrane(eye, static_cast<float>(rest), {1e5, 0.49, 2e-3});
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-40, 40), size(3, 40);
  std::uniform_int_distribution<Index> column(0, 149), row(0, 109);
  const auto depth_of = [&](const Overlap& overlap) {
    const auto fine = object(camera(150, 110, 1e-4), overlap);
    Image<float> depth(150, 110);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      depth.pixels()[i] = static_cast<float>(fine.pixels()[i]);
    }
    return depth;
  };
  const Image<float> gel_at_rest(150, 110, static_cast<float>(rest));
  auto used = membrane.make_workspace(150, 110);
  for (int round = 0; round < 12; ++round) {
    auto depth = depth_of(ball(size(random), 3, place(random), place(random)));
    for (int k = 0; k < 40; ++k) {
      depth(column(random), row(random)) = static_cast<float>(k % 2 == 0 ? inf : unknown);
    }
    auto fresh = membrane.make_workspace(150, 110);
    Image<float> whole(150, 110), part(150, 110, -1.0F);
    membrane.press_into(whole, {depth.view(), gel_at_rest.view(), {0, 0, 150, 110}}, fresh);
    const Index a = column(random), b = column(random), c = row(random), d = row(random);
    const Window window{std::min(a, b), std::min(c, d), std::max(a, b) + 1, std::max(c, d) + 1};
    membrane.press_into(part, {depth.view(), gel_at_rest.view(), window}, used);
    for (Index y = 0; y < 110; ++y) {
      for (Index x = 0; x < 150; ++x) {
        const bool is_in =
            x >= window.left && x < window.right && y >= window.top && y < window.bottom;
        CHECK(part(x, y) == (is_in ? whole(x, y) : -1.0F));
      }
    }
  }
}

// How far a surface is from that of the same object some pixels further left, as a share of the
// press.
double moved_off(const Image<double>& here, const Image<double>& there, Index by, double press) {
  double most = 0;
  for (Index y = 0; y < here.height(); ++y) {
    for (Index x = 0; x + by < here.width(); ++x) {
      most = std::max(most, std::abs(there(x + by, y) - here(x, y)) / press);
    }
  }
  return most;
}

TEST_CASE("a move by whole cells moves the surface, by a pixel it changes no more than is told") {
  constexpr double pitch = 1e-4, press = 2;
  const auto eye = camera(120, 90, pitch);
  const Image<double> gel(120, 90, rest);
  const auto block = [](double by) -> Overlap {
    return [=](double x, double y) {
      return x - by > -12 && x - by < 5 && y > -9 && y < 22 ? press : -inf;
    };
  };
  const auto round = [](double by) { return ball(20, press, by); };
  for (const double thickness : {5.0, 10.0, 20.0, 40.0}) {
    for (const double nu : {0.3, 0.48, 0.5}) {
      CAPTURE(thickness);
      CAPTURE(nu);
      const Gel told{1e5, nu, thickness * pitch};
      const auto surface = [&](const auto& membrane, const Overlap& overlap) {
        return surface_depth(membrane, object(eye, overlap), gel);
      };
      const BulgingMembrane<double> bulging(eye, rest, told);
      const auto off = [&](const auto& what, Index by) {
        return moved_off(surface(bulging, what(0)), surface(bulging, what(by)), by, press * pitch);
      };
      // Cells are two pixels wide under the object, wider ones stand still.
      CHECK(off(block, 2) < 0.002);
      CHECK(off(round, 2) < 0.002);
      CHECK(off(block, 1) < (thickness < 10 ? 0.9 : 0.6));
      CHECK(off(round, 1) < 0.035);
      // The layer itself is of no cells.
      const LayerMembrane<double> whole(ElasticLayer(eye, rest, told, {.sideways = false}));
      CHECK(moved_off(surface(whole, block(0)), surface(whole, block(1)), 1, press * pitch) <
            0.002);
    }
  }
}

TEST_CASE("at rest, with holes, at the border, and what is not known") {
  const auto eye = camera(90, 70, 1e-4);
  const BulgingMembrane<double> membrane(eye, rest, {1e5, 0.49, 2e-3});
  Image<double> gel_at_rest(90, 70, rest);
  gel_at_rest(3, 4) = 0;
  const auto untouched = membrane.depth(Image<double>(90, 70, inf), gel_at_rest);
  for (Index y = 0; y < 70; ++y) {
    for (Index x = 0; x < 90; ++x) {
      CHECK((x == 3 && y == 4 ? std::isnan(untouched(x, y)) : untouched(x, y) == rest));
    }
  }
  // Never in the object, wherever it stands; what is not known spreads to no other pixel.
  for (const auto& [x0, y0] : {std::pair{0.0, 0.0}, {-44.0, -34.0}, {44.0, 0.0}}) {
    auto depth = object(eye, ball(9, 2, x0, y0));
    depth(45, 35) = unknown;
    depth(50, 30) = -1;
    const auto surface = membrane.depth(depth, gel_at_rest);
    for (Index y = 0; y < 70; ++y) {
      for (Index x = 0; x < 90; ++x) {
        const bool is_hole = (x == 45 && y == 35) || (x == 50 && y == 30) || (x == 3 && y == 4);
        CHECK(std::isnan(surface(x, y)) == is_hole);
        if (!is_hole) CHECK(surface(x, y) <= std::max(depth(x, y), depth(x, y) + 1e-18));
      }
    }
  }
}

TEST_CASE("more cells than there are pixels are as many as there are pixels") {
  const Camera<double> eye{200, 200, 19.5, 14.5, 40, 30};
  Image<double> object(40, 30, std::numeric_limits<double>::infinity());
  for (Index y = 8; y < 25; ++y) {
    for (Index x = 11; x < 33; ++x) object(x, y) = 0.03 - 1e-4 + 1e-6 * std::hypot(x - 20, y - 15);
  }
  const Image<double> gel_at_rest(40, 30, 0.03);
  const auto surface = [&](Index cells) {
    return BulgingMembrane<double>(eye, 0.03, {}, {.cells = cells}).depth(object, gel_at_rest);
  };
  const Image<double> own = surface(40);
  for (const Index cells : {41, 2000, 2000000000}) CHECK(surface(cells) == own);
}

TEST_CASE("bad input is named") {
  const auto eye = camera(40, 30, 1e-4);
  const auto says = [&](const Gel& gel, const BulgeOptions& options = {}, double depth = rest) {
    return refusal([&] { return BulgingMembrane<double>(eye, depth, gel, options); });
  };
  CHECK(says({}) == "accepted");
  CHECK(contains(says({.poisson_ratio = 0.75}), "Poisson ratio 0.75"));
  CHECK(contains(says({.poisson_ratio = unknown}), "Poisson ratio"));
  CHECK(contains(says({.thickness = 0}), "thickness 0"));
  CHECK(contains(says({.thickness = unknown}), "thickness"));
  CHECK(contains(says({}, {.cells = 0}), "0 cells"));
  CHECK(contains(says({}, {.kernels = 0}), "0 kernels"));
  CHECK(contains(says({}, {.iterations = 0}), "0 iterations"));
  CHECK(contains(says({}, {.tolerance = 0}), "tolerance 0"));
  for (const double bad : {1.0, 7.0, inf}) {
    CHECK(contains(says({}, {.tolerance = bad}), "is not between 0 and 1"));
  }
  CHECK(contains(says({}, {}, -1), "rest depth -1"));
  const BulgingMembrane<double> membrane(eye, rest);
  CHECK(contains(refusal([&] { return membrane.make_workspace(30, 40); }), "30 x 40"));
  CHECK(contains(
      refusal([&] { return membrane.depth(Image<double>(3, 3), Image<double>(40, 30, rest)); }),
      "3 x 3"));
}
