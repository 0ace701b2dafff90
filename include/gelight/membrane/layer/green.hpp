#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <type_traits>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

// How a layer that is bonded to a rigid base yields to loads on its surface. Lengths are in pixels
// and loads in shear moduli throughout; "down" is into the layer.

namespace gelight::detail {

/// The layer's displacements under a load exp(i k x), times the wave number k. All are functions of
/// c = k thickness alone; a half-space's are those at c = infinity.
struct LayerResponse {
  double down_by_pressure;    ///< and in phase
  double along_by_traction;   ///< traction along the wave
  double across_by_traction;  ///< traction along the crests
  /// Along the wave by a pressure, a quarter of a wave ahead; and, by reciprocity, down by a
  /// traction along the wave, a quarter of a wave behind.
  double coupling;
};

[[nodiscard]] inline LayerResponse half_space_response(double nu) {
  return {1 - nu, 1 - nu, 1, (1 - 2 * nu) / 2};
}

/// The pressure's after Hannah, Contact stress and deformation in a thin elastic layer, 1951,
/// doi:10.1093/qjmam/4.1.94; the others by the same steps.
[[nodiscard]] inline LayerResponse layer_response(double c, double nu) {
  // All times exp(-2 c), so that nothing overflows.
  const double decay = std::exp(-2 * c), a = 3 - 4 * nu, b = 1 - 2 * nu;
  const double sinh_cosh = (1 - decay) * (1 + decay) / 4;
  const double sinh_squared = (1 - decay) * (1 - decay) / 4;
  const double cosh_squared = (1 + decay) * (1 + decay) / 4;
  double bending = a * sinh_cosh - c * decay;
  if (c < 0.05) {
    // What is left where the difference loses its digits: its series.
    const double square = c * c;
    bending =
        decay * c * (2 * b + a * square * (2.0 / 3 + square * (2.0 / 15 + square * (4.0 / 315))));
  }
  const double denominator = a * cosh_squared + (b * b + c * c) * decay;
  return {(1 - nu) * bending / denominator, (1 - nu) * (a * sinh_cosh + c * decay) / denominator,
          std::tanh(c), (a * b * sinh_squared - c * c * decay) / (2 * denominator)};
}

/// Bessel functions of the first kind of orders 0 to 2, x >= 0.
[[nodiscard]] inline std::array<double, 3> bessel(double x) {
#ifdef _MSC_VER
  const double j0 = ::_j0(x), j1 = ::_j1(x);
#else
  const double j0 = ::j0(x), j1 = ::j1(x);
#endif
  // The recurrence cancels near zero.
  const double square = x * x;
  const double j2 = x < 0.5 ? square / 8 * (1 - square / 12 * (1 - square / 32 * (1 - square / 60)))
                            : 2 * j1 / x - j0;
  return {j0, j1, j2};
}

/// What a layer's response to a point load has beyond a half-space's, by distance over thickness
/// r, where it is smooth: the integral over c of the difference of two responses times a Bessel
/// function of c r. Tabulated, densely where it varies most, and interpolated by cubics.
template <class Real = double>
class LayerCorrection {
 public:
  enum Part { pressure, mean, difference, coupling };  // mean, difference: of along and across

  /// Beyond this many thicknesses of the layer nothing moves: less than 1e-10 of what moves at one.
  static constexpr Real reach = 20;

  /// For distances over thickness up to the smaller of `reach` and what is asked for.
  LayerCorrection(Real nu, std::type_identity_t<Real> farthest) {
    const Real end = std::min(farthest, reach);
    nodes_.resize(static_cast<std::size_t>(place_of(end)) + 2);
    // Panels that few waves fit in, as many as Gauss and Legendre's rule of ten points resolves.
    const auto slow = static_cast<std::size_t>(place_of(8)) + 1;
    const std::size_t middle = std::min(slow, nodes_.size());
    add_panels(nu, 20, 0, middle);
    add_panels(nu, 40, middle, nodes_.size());
  }

  /// At a distance over thickness.
  [[nodiscard]] Real at(Part part, Real r) const {
    const Real place = place_of(r);
    const auto i = static_cast<std::ptrdiff_t>(place);
    const Real t = place - static_cast<Real>(i), s = 1 - t, gap = r_of(i + 1) - r_of(i);
    const Node &a = nodes_[i], &b = nodes_[i + 1];
    return s * s * ((1 + 2 * t) * a.value[part] + t * gap * a.slope[part]) +
           t * t * ((1 + 2 * s) * b.value[part] - s * gap * b.slope[part]);
  }

 private:
  struct Node {
    std::array<Real, 4> value{}, slope{};
  };

  // Nodes are 16 a thickness up to 4, and 4 beyond.
  static constexpr Real dense = 16, sparse = 4, dense_to = 4;
  [[nodiscard]] static Real place_of(Real r) {
    return r < dense_to ? r * dense : dense_to * dense + (r - dense_to) * sparse;
  }
  [[nodiscard]] static Real r_of(std::ptrdiff_t node) {
    const Real place = static_cast<Real>(node), beyond = place - dense_to * dense;
    return beyond < 0 ? place / dense : dense_to + beyond / sparse;
  }

  // Beyond c = 20 the responses differ by less than 1e-14.
  void add_panels(Real nu, int panels, std::size_t begin, std::size_t end) {
    const Real width = Real(20) / panels;
    constexpr std::array points{0.1488743389816312, 0.4333953941292472, 0.6794095682990244,
                                0.8650633666889845, 0.9739065285171717};
    constexpr std::array weights{0.2955242247147529, 0.2692667193099963, 0.2190863625159820,
                                 0.1494513491505806, 0.0666713443086881};
    const LayerResponse far = half_space_response(nu);
    for (int panel = 0; panel < panels; ++panel) {
      const Real middle = (panel + Real(0.5)) * width;
      for (std::size_t i = 0; i < 2 * points.size(); ++i) {
        const Real side = i < points.size() ? 1 : -1;
        const Real c = middle + side * width / 2 * points[i % points.size()];
        const LayerResponse here = layer_response(c, nu);
        const Real weight = weights[i % points.size()] * width / 2;
        const std::array<Real, 4> rest{here.down_by_pressure - far.down_by_pressure,
                                       (here.along_by_traction + here.across_by_traction -
                                        far.along_by_traction - far.across_by_traction) /
                                           2,
                                       (here.along_by_traction - here.across_by_traction -
                                        far.along_by_traction + far.across_by_traction) /
                                           2,
                                       here.coupling - far.coupling};
        add_wave(c, {weight * rest[0], weight * rest[1], weight * rest[2], weight * rest[3]}, begin,
                 end);
      }
    }
  }

  void add_wave(Real c, const std::array<Real, 4>& height, std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const Real r = r_of(static_cast<std::ptrdiff_t>(n));
      const auto [j0, j1, j2] = bessel(c * r);
      // J1(x) / x and J2(x) / x.
      const Real over1 = (j0 + j2) / 2, over2 = r > 0 ? j2 / (c * r) : 0;
      auto& [value, slope] = nodes_.data()[n];
      value[pressure] += height[pressure] * j0;
      slope[pressure] -= height[pressure] * c * j1;
      value[mean] += height[mean] * j0;
      slope[mean] -= height[mean] * c * j1;
      value[difference] += height[difference] * j2;
      slope[difference] += height[difference] * c * (j1 - 2 * over2);
      value[coupling] += height[coupling] * j1;
      slope[coupling] += height[coupling] * c * (j0 - over1);
    }
  }

  Array<Node> nodes_;
};

/// The grid on which a layer's surface is loaded, and what it is made of.
struct LayerGrid {
  Index width = 0, height = 0;  ///< offsets between its pixels are below these
  double aspect = 1;            ///< a pixel's height over its width
  double thickness = 0;         ///< of the layer, in pixels' widths
  double poisson_ratio = 0;
};

/// How the layer differs from a half-space, none where it is one.
template <class Real = double>
[[nodiscard]] std::optional<LayerCorrection<Real>> layer_correction(const LayerGrid& grid) {
  if (!std::isfinite(grid.thickness)) return {};
  const double diagonal = std::hypot(grid.width, grid.aspect * grid.height);
  return LayerCorrection<Real>(grid.poisson_ratio, diagonal / grid.thickness);
}

/// Functions of the offset from one pixel, which is loaded, to the centre of another: integrals
/// over the pixel, by columns and rows from zero on.
///
/// `corner(x, y)` gives the integrals, for a half-space, over the quadrant of which (x, y) is the
/// corner; `rest(cos, sin, r)` what a layer's functions have beyond that in a direction, at a
/// distance over thickness.
template <std::size_t N, class Real, class Corner, class Rest>
[[nodiscard]] Array<std::array<Real, N>> integrate_pixels(
    const LayerGrid& grid, const std::optional<LayerCorrection<Real>>& correction,
    const Corner& corner, const Rest& rest) {
  const auto at = [&](Index x, Index y) { return std::ptrdiff_t{y} * grid.width + x; };
  Array<std::array<Real, N>> sums(static_cast<std::size_t>(grid.width) *
                                  static_cast<std::size_t>(grid.height));
  Array<std::array<Real, N>> above(static_cast<std::size_t>(grid.width) + 1), below(above);
  for (Index j = 0; j <= grid.height; ++j) {
    std::swap(above, below);
    for (Index i = 0; i <= grid.width; ++i) {
      below[i] = corner(i - 0.5, grid.aspect * (j - 0.5));
    }
    if (j == 0) continue;
    for (Index i = 0; i < grid.width; ++i) {
      for (std::size_t k = 0; k < N; ++k) {
        sums[at(i, j - 1)][k] = below[i + 1][k] - below[i][k] - above[i + 1][k] + above[i][k];
      }
    }
  }
  if (!correction) return sums;
  // Gauss and Legendre's rule of two points, in pieces smaller than the thickness.
  const double thickness = grid.thickness, reach = LayerCorrection<Real>::reach * thickness;
  const int pieces = static_cast<int>(std::ceil(2 * std::max(1.0, grid.aspect) / thickness));
  const double piece = 1.0 / pieces, side = piece / (2 * std::numbers::sqrt3);
  const double weight = grid.aspect * piece * piece / 4 / thickness;
  Array<Real> places;
  for (int i = 0; i < pieces; ++i) {
    const double middle = (i + 0.5) * piece - 0.5;
    places.push_back(middle - side);
    places.push_back(middle + side);
  }
  for (Index row = 0; row < grid.height; ++row) {
    for (Index column = 0; column < grid.width; ++column) {
      auto& sum = sums[at(column, row)];
      if (std::hypot(column + 0.5, grid.aspect * (row + 0.5)) >= reach) {
        sum = {};  // too far away to move
        continue;
      }
      for (const Real v : places) {
        for (const Real u : places) {
          const double x = column + u, y = grid.aspect * (row + v), r = std::sqrt(x * x + y * y);
          const auto value = rest(x / r, y / r, r / thickness);
          for (std::size_t k = 0; k < N; ++k) sum[k] += weight * value[k];
        }
      }
    }
  }
  return sums;
}

/// asinh(x / |y|), given r = hypot(x, y): three times as fast.
[[nodiscard]] inline double inverse_sinh(double x, double y, double r) {
  const double size = std::log((std::abs(x) + r) / std::abs(y));
  return x < 0 ? -size : size;
}

/// How far a pressure on one pixel moves another's centre down. For a half-space exactly the
/// integral (Love, The stress produced in a semi-infinite solid by pressure on part of the
/// boundary, 1929, doi:10.1098/rsta.1929.0009).
template <class Real>
class PressureGreen {
 public:
  PressureGreen(const LayerGrid& grid, const std::optional<LayerCorrection<Real>>& correction)
      : width_(grid.width) {
    const Real scale = 1 / (2 * std::numbers::pi), near = scale * (1 - grid.poisson_ratio);
    values_ = integrate_pixels<1>(
        grid, correction,
        [&](Real x, Real y) -> std::array<Real, 1> {
          const Real r = std::sqrt(x * x + y * y);
          return {near * (y * inverse_sinh(x, y, r) + x * inverse_sinh(y, x, r))};  // of 1 / r
        },
        [&](Real, Real, Real r) -> std::array<Real, 1> {
          return {scale * correction->at(LayerCorrection<Real>::pressure, r)};
        });
  }

  [[nodiscard]] Real down(Index x, Index y) const {
    return values_[std::ptrdiff_t{std::abs(y)} * width_ + std::abs(x)][0];
  }

 private:
  Index width_;
  Array<std::array<Real, 1>> values_;
};

/// How far pressure and traction on one pixel move another's centre sideways: after Cerruti, as
/// in Johnson, Contact Mechanics, 1985, doi:10.1017/CBO9781139171731, section 3.6. By reciprocity
/// traction moves it down by what pressure moves it sideways, with the sign changed.
template <class Real>
class SidewaysGreen {
 public:
  SidewaysGreen(const LayerGrid& grid, const std::optional<LayerCorrection<Real>>& correction)
      : width_(grid.width) {
    const Real nu = grid.poisson_ratio, scale = 1 / (2 * std::numbers::pi);
    const Real pull = -scale * (1 - 2 * nu) / 2;
    values_ = integrate_pixels<5>(
        grid, correction,
        [&](Real x, Real y) -> std::array<Real, 5> {
          const Real r = std::hypot(x, y), log_r = std::log(r);
          const Real xx = y * inverse_sinh(x, y, r);  // of x^2 / r^3
          const Real yy = x * inverse_sinh(y, x, r);  // of y^2 / r^3
          // Of x / r^2, y / r^2 and x y / r^3.
          return {pull * (y * log_r + x * std::atan(y / x)),
                  pull * (x * log_r + y * std::atan(x / y)), scale * (xx + (1 - nu) * yy),
                  scale * (yy + (1 - nu) * xx), -scale * nu * r};
        },
        [&](Real cos, Real sin, Real r) -> std::array<Real, 5> {
          const Real mean = scale * correction->at(LayerCorrection<Real>::mean, r);
          const Real difference = scale * correction->at(LayerCorrection<Real>::difference, r);
          const Real coupling = scale * correction->at(LayerCorrection<Real>::coupling, r);
          const Real twice = cos * cos - sin * sin;
          return {-coupling * cos, -coupling * sin, mean - twice * difference,
                  mean + twice * difference, -2 * cos * sin * difference};
        });
  }

  /// Along x and y, by pressure.
  ///@{
  [[nodiscard]] Real x(Index x, Index y) const { return sign(x) * at(x, y)[0]; }
  [[nodiscard]] Real y(Index x, Index y) const { return sign(y) * at(x, y)[1]; }
  ///@}
  /// Along x by traction along x, along y by traction along y, and along the one by the other.
  ///@{
  [[nodiscard]] Real xx(Index x, Index y) const { return at(x, y)[2]; }
  [[nodiscard]] Real yy(Index x, Index y) const { return at(x, y)[3]; }
  [[nodiscard]] Real xy(Index x, Index y) const { return sign(x) * sign(y) * at(x, y)[4]; }
  ///@}

 private:
  [[nodiscard]] static Real sign(Index i) { return i < 0 ? -1 : 1; }
  [[nodiscard]] const std::array<Real, 5>& at(Index x, Index y) const {
    return values_[std::ptrdiff_t{std::abs(y)} * width_ + std::abs(x)];
  }

  Index width_;
  Array<std::array<Real, 5>> values_;
};

}  // namespace gelight::detail
