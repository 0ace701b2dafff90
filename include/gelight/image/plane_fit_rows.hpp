#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "gelight/core/bits.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"

// Planes fitted to the points of windows, a row of pixels at a time, in plain loops over planar
// arrays that compilers vectorise. In double: variances are small differences of large sums.
namespace gelight::detail {

/// The sums over a window that its covariance is made of: how many points, their coordinates, and
/// the products of these.
enum Moment : std::size_t { m_n, m_x, m_y, m_z, m_xx, m_xy, m_xz, m_yy, m_yz, m_zz, moments };

/// 1 / sqrt(x) to rounding, by Newton's iteration from a first guess made of the number's bits.
/// Unlike std::sqrt, which has to set errno, it is vectorised. (McEniry, The mathematics behind the
/// fast inverse square root function code, 2007)
[[nodiscard]] inline double root_of_inverse(double x) {
  const std::uint64_t guess = 0x5fe6eb50c7b537a9 - (detail::bit_cast<std::uint64_t>(x) >> 1);
  double y = detail::bit_cast<double>(guess);
  for (int step = 0; step < 4; ++step) y *= 1.5 - 0.5 * x * y * y;
  return y;
}

/// What is summed down a column, where x = u z and y = v z with one u: n, z, v z and z^2, v z^2,
/// v^2 z^2.
enum ColumnMoment : std::size_t { c_n, c_z, c_vz, c_zz, c_vzz, c_vvzz, column_moments };

/// Adds `row` to `sum`.
inline void add_row(double* __restrict sum, const double* row, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) sum[i] += row[i];
}

/// The points of a row of depths; nothing where a depth is not finite.
template <class T>
void column_moments_of(const std::array<double*, column_moments>& out, const T* depth, double v,
                       std::ptrdiff_t count) {
  double* __restrict n = out[c_n], * __restrict z = out[c_z], * __restrict vz = out[c_vz], * __restrict zz = out[c_zz], * __restrict vzz = out[c_vzz], * __restrict vvzz = out[c_vvzz];
  // A loop for each choice: compilers turn several of them in one into branches.
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double value = static_cast<double>(depth[i]);
    n[i] = value - value == 0 ? 1.0 : 0.0;
  }
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double value = static_cast<double>(depth[i]);
    z[i] = value - value == 0 ? value : 0.0;
  }
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double d = z[i];
    vz[i] = v * d;
    zz[i] = d * d;
    vzz[i] = v * (d * d);
    vvzz[i] = v * v * (d * d);
  }
}

/// out[i] = the sum of row[i] and its neighbours after it, an odd `window` of them, by sums of two,
/// four, eight, which `row` becomes.
inline void window_sums(double* __restrict out, double* __restrict row, Index window,
                        std::ptrdiff_t count) {
  std::copy_n(row, count, out);
  std::ptrdiff_t done = 1;
  for (std::ptrdiff_t power = 2; power <= window; power *= 2) {
    const std::ptrdiff_t half = power / 2, left = count + window - power;
    for (std::ptrdiff_t i = 0; i < left; ++i) row[i] += row[i + half];
    if ((window & power) == 0) continue;
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += row[i + done];
    done += power;
  }
}

/// The planes of a row of unit vectors; `facing` is their product with the pixels' rays.
template <class T>
struct DirectionRow {
  T *x, *y, *z, *facing;
};

/// Directions are found for this many pixels at a time, in arrays of their own: then compilers know
/// that these overlap nothing, and vectorise.
inline constexpr std::size_t fit_tile = 64;
using FitTile = std::array<double, fit_tile>;

/// Added where 0 may be divided by, to leave 0: to compare instead makes branches. Less than any
/// square of a depth within these bounds.
inline constexpr double tiny = 1e-290, least_fitted_depth = 1e-140, most_fitted_depth = 1e140;

/// The covariances of windows, scaled to a trace of 1.
struct Covariances {
  FitTile xx, xy, xz, yy, yz, zz;

  void take(const std::array<const double*, moments>& sums, std::size_t count) {
    // Less than any trace, as a share of the sum of the depths' squares, that is not rounding
    // alone.
    constexpr double no_trace = 1e-24;
    for (std::size_t i = 0; i < count; ++i) {
      const double share = 1 / (sums[m_n][i] + tiny);
      const double x = sums[m_x][i] * share, y = sums[m_y][i] * share, z = sums[m_z][i] * share;
      xx[i] = sums[m_xx][i] * share - x * x;
      xy[i] = sums[m_xy][i] * share - x * y;
      xz[i] = sums[m_xz][i] * share - x * z;
      yy[i] = sums[m_yy][i] * share - y * y;
      yz[i] = sums[m_yz][i] * share - y * z;
      zz[i] = sums[m_zz][i] * share - z * z;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double scale = 1 / (xx[i] + yy[i] + zz[i] + (no_trace * sums[m_zz][i] + tiny));
      xx[i] *= scale;
      xy[i] *= scale;
      xz[i] *= scale;
      yy[i] *= scale;
      yz[i] *= scale;
      zz[i] *= scale;
    }
  }

  /// The least eigenvalues, by Newton's method from below on the characteristic polynomials.
  void least_variances(FitTile& least, std::size_t count) const {
    constexpr std::size_t most_steps = 20;
    constexpr double enough = 1e-13;  // of a step, where all have come down to rounding
    FitTile minors, determinant, step;
    for (std::size_t i = 0; i < count; ++i) {
      const double a = yy[i] * zz[i] - yz[i] * yz[i], b = xy[i] * zz[i] - xz[i] * yz[i],
                   c = xy[i] * yz[i] - xz[i] * yy[i];
      minors[i] = a + (xx[i] * zz[i] - xz[i] * xz[i]) + (xx[i] * yy[i] - xy[i] * xy[i]);
      determinant[i] = xx[i] * a - xy[i] * b + xz[i] * c;
      least[i] = 0;
    }
    for (std::size_t k = 0; k < most_steps; ++k) {
      for (std::size_t i = 0; i < count; ++i) {
        const double value = ((least[i] - 1) * least[i] + minors[i]) * least[i] - determinant[i];
        const double slope = (3 * least[i] - 2) * least[i] + minors[i];
        step[i] = value / (std::abs(slope) + 1e-20);
        least[i] -= step[i];
      }
      const auto is_small = [](double s) { return std::abs(s) < enough; };
      if (std::all_of(step.begin(), step.begin() + static_cast<std::ptrdiff_t>(count), is_small)) {
        return;
      }
    }
  }
};

/// What takes a pixel's ray to a multiple of its plane's normal: a covariance's adjugate, when a
/// share of the least variance has been taken from it. With all of it, the adjugate is a multiple
/// of n n^T, and so leads along n, to the side that the ray goes to.
struct Adjugates {
  FitTile xx, yy, zz, xy, xz, yz;

  void take(const Covariances& spread, const FitTile& taken, std::size_t i) {
    const double a = spread.xx[i] - taken[i], b = spread.yy[i] - taken[i],
                 c = spread.zz[i] - taken[i];
    const double ab = spread.xy[i], ac = spread.xz[i], bc = spread.yz[i];
    xx[i] = b * c - bc * bc;
    yy[i] = a * c - ac * ac;
    zz[i] = a * b - ab * ab;
    xy[i] = ac * bc - ab * c;
    xz[i] = ab * bc - ac * b;
    yz[i] = ab * ac - a * bc;
  }
};

/// Whether the pixels of windows span an area of the image, more than 0, rather than lie on a line
/// of it, from the sums over their points: by the least variance of their rays, weighted by the
/// squares of the depths.
inline void spanned_areas(FitTile& area, const std::array<const double*, moments>& sums,
                          std::size_t count) {
  // What variances of rays are rounded by, a thousand times over; pixels that are a millionth of
  // the focal length apart have more.
  constexpr double rounded_off = 1e-13;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = 1 / (sums[m_zz][i] + tiny);
    const double u = sums[m_xz][i] * share, v = sums[m_yz][i] * share;
    const double uu = sums[m_xx][i] * share - u * u, vv = sums[m_yy][i] * share - v * v,
                 uv = sums[m_xy][i] * share - u * v;
    const double most_rounding = rounded_off * (1 + u * u + v * v);
    area[i] = (uu * vv - uv * uv) - most_rounding * (uu + vv + most_rounding);
  }
}

/// The unit vectors along which the points of windows spread least, towards the camera; zero where
/// their pixels lie on a line of the image: the plane through these is seen edge-on, from either
/// side, whatever their depths.
template <class T>
void flattest_directions(const DirectionRow<T>& out, const std::array<const double*, moments>& sums,
                         const double* u, double v, std::size_t count) {
  // Of points on a line the share of the second variance is what the sums were rounded by.
  constexpr double rounded_off = 1e-10;
  // The square of the cosine at which a plane is seen edge-on: no depth image shows more than its
  // side, and which side is soon a matter of rounding. From there on less and less of the least
  // variance is taken away, so that the direction turns to where the ray still meets a plane from
  // the front, rather than to the other side at once.
  constexpr double edge_on = 1e-4;
  Covariances spread;
  Adjugates adjugate;
  FitTile least, x, y, z, unit, flatness, area;
  spread.take(sums, count);
  spread.least_variances(least, count);
  const auto point = [&](std::size_t i) {
    adjugate.take(spread, least, i);
    x[i] = adjugate.xx[i] * u[i] + adjugate.xy[i] * v + adjugate.xz[i];
    y[i] = adjugate.xy[i] * u[i] + adjugate.yy[i] * v + adjugate.yz[i];
    z[i] = adjugate.xz[i] * u[i] + adjugate.yz[i] * v + adjugate.zz[i];
    unit[i] = -root_of_inverse(x[i] * x[i] + y[i] * y[i] + z[i] * z[i] + tiny);
  };
  for (std::size_t i = 0; i < count; ++i) {
    point(i);
    const double others = 1 - 3 * least[i];  // the sum of the other variances less twice this one
    flatness[i] = adjugate.xx[i] + adjugate.yy[i] + adjugate.zz[i] - rounded_off * others * others;
  }
  spanned_areas(area, sums, count);
  // A loop for each choice: compilers turn several of them in one into branches.
  for (std::size_t i = 0; i < count; ++i) unit[i] = flatness[i] > 0 ? unit[i] : 0.0;
  for (std::size_t i = 0; i < count; ++i) unit[i] = area[i] > 0 ? unit[i] : 0.0;
  const auto facing = [&](std::size_t i) { return unit[i] * (u[i] * x[i] + v * y[i] + z[i]); };
  const auto is_edge_on = [&](std::size_t i) {
    return facing(i) * facing(i) < edge_on * (u[i] * u[i] + v * v + 1) ? 1.0 : 0.0;
  };
  double edges = 0;
  for (std::size_t i = 0; i < count; ++i) edges += is_edge_on(i);
  for (std::size_t i = 0; i < count && edges > 0; ++i) {
    if (unit[i] == 0 || is_edge_on(i) == 0) continue;
    const double square = facing(i) * facing(i) / (u[i] * u[i] + v * v + 1);
    least[i] = std::max(least[i], 0.0) * (square / edge_on);
    point(i);
  }
  T *const nx = out.x, *const ny = out.y, *const nz = out.z, *const towards = out.facing;
  for (std::size_t i = 0; i < count; ++i) {
    nx[i] = static_cast<T>(unit[i] * x[i]);
    ny[i] = static_cast<T>(unit[i] * y[i]);
    nz[i] = static_cast<T>(unit[i] * z[i]);
    towards[i] = static_cast<T>(facing(i));
  }
}

/// By how much a coordinate of a fitted plane's unit normal may be rounded. (Measured on planes
/// that no rounding of depths had bent: a third of it with a focal length of 100 to 100000 pixels.)
template <std::floating_point T>
[[nodiscard]] T fit_rounding(const Camera<T>& camera, Index radius) {
  const double f = std::max<double>(camera.fx, camera.fy);
  const double r = std::clamp(std::min(camera.width, camera.height) - 1, 1, radius);
  // A variance is a difference of squares of coordinates. By depth^2, that of a window with its
  // centre on the image's edge is r (r + 2) / 12 pixels^2, and the squares are those of a ray.
  double square = 0;
  for (const Index y : {Index{0}, camera.height - 1}) {
    for (const Index x : {Index{0}, camera.width - 1}) {
      const auto ray = camera.ray(static_cast<T>(x), static_cast<T>(y));
      square = std::max<double>(square, dot(ray, ray));
    }
  }
  constexpr double roundings = 4;
  const double of_variance =
      roundings * std::numeric_limits<double>::epsilon() * square * f * f * 12 / (r * (r + 2));
  // The normal is returned in T, and from depths in T: over the pixel next to it a slope is
  // rounded by their epsilon times the focal length.
  return static_cast<T>(of_variance) + (T(f) + 8) * std::numeric_limits<T>::epsilon();
}

/// Fits planes to the (2 radius + 1)^2 windows around the pixels of some columns, row after row.
template <std::floating_point T>
class PlaneFitRows {
 public:
  PlaneFitRows() = default;
  PlaneFitRows(const Camera<T>& camera, Index radius)
      : camera_(camera.template cast<double>()),
        radius_(std::min(radius, std::max(camera.width, camera.height))),
        stride_(camera.width + 2 * radius_),
        block_(rows_of_block() * column_moments * static_cast<std::size_t>(stride_)),
        begun_(column_moments * static_cast<std::size_t>(stride_)),
        down_(moments * static_cast<std::size_t>(stride_)),
        window_(down_.size()) {
    for (Index x = -radius_; x < camera.width + radius_; ++x) {
      columns_.push_back(camera_.ray(x, 0).x());
    }
  }

  [[nodiscard]] Index radius() const { return radius_; }

  /// Begins anew, for the columns from `left` to before `right`.
  void start(Index left, Index right) {
    left_ = left;
    right_ = right;
    entered_ = 0;
    std::fill(block_.begin(), block_.end(), 0.0);
    std::fill(begun_.begin(), begun_.end(), 0.0);
  }

  /// Moves the windows down by a row: `depth` is row y, or null beyond the image's edge. The sums
  /// over the last 2 radius + 1 rows are those over the end of the last full block and the
  /// beginning of the next one: nothing is ever taken away from them again, which would leave its
  /// rounding.
  void enter(const T* depth, Index y) {
    const Index first = std::max(Index{0}, left_ - radius_);
    const Index end = std::min(camera_.width, right_ + radius_);
    const std::size_t at = static_cast<std::size_t>(entered_) % rows_of_block();
    std::array<double*, column_moments> row{};
    for (std::size_t m = 0; m < column_moments; ++m) row[m] = block(at, m) + first + radius_;
    const std::ptrdiff_t count = end - first;
    if (depth != nullptr) {
      column_moments_of(row, depth + first, camera_.ray(0, y).y(), count);
    } else {
      for (double* const moment : row) std::fill_n(moment, count, 0.0);
    }
    for (std::size_t m = 0; m < column_moments; ++m) {
      double* const begun = begun_.data() + m * static_cast<std::size_t>(stride_);
      add_row(begun + first + radius_, row[m], count);
    }
    if (at + 1 == rows_of_block()) close_block(first + radius_, count);
    ++entered_;
  }

  /// The normals of row y, the one `radius` rows above the last that entered; `n` begins at the
  /// first of the columns.
  void fit(const DirectionRow<T>& n, Index y) {
    const Index first = left_, count = right_ - left_;
    const std::ptrdiff_t padded = count + 2 * radius_;
    const std::size_t at = static_cast<std::size_t>(entered_ - 1) % rows_of_block();
    const bool is_whole = at + 1 == rows_of_block();
    std::array<const double*, column_moments> ended{}, begun{};
    for (std::size_t m = 0; m < column_moments; ++m) {
      ended[m] = block(is_whole ? 0 : at + 1, m) + first;
      begun[m] = begun_.data() + m * static_cast<std::size_t>(stride_) + first;
    }
    std::array<double*, moments> down{}, sums{};
    for (std::size_t m = 0; m < moments; ++m) {
      down[m] = down_.data() + m * static_cast<std::size_t>(stride_);
      sums[m] = window_.data() + m * static_cast<std::size_t>(stride_);
    }
    spread(down, ended, begun, columns_.data() + first, padded);
    for (std::size_t m = 0; m < moments; ++m) {
      window_sums(sums[m], down[m], 2 * radius_ + 1, count);
    }
    for (Index x = 0; x < count; x += static_cast<Index>(fit_tile)) {
      std::array<const double*, moments> tile{};
      for (std::size_t m = 0; m < moments; ++m) tile[m] = sums[m] + x;
      flattest_directions(DirectionRow<T>{n.x + x, n.y + x, n.z + x, n.facing + x}, tile,
                          columns_.data() + radius_ + first + x, camera_.ray(0, y).y(),
                          std::min(fit_tile, static_cast<std::size_t>(count - x)));
    }
  }

 private:
  [[nodiscard]] std::size_t rows_of_block() const {
    return 2 * static_cast<std::size_t>(radius_) + 1;
  }
  [[nodiscard]] double* block(std::size_t row, std::size_t moment) {
    return block_.data() + (row * column_moments + moment) * static_cast<std::size_t>(stride_);
  }

  // Of a full block: makes each row the sum of it and all after it.
  void close_block(std::ptrdiff_t first, std::ptrdiff_t count) {
    for (std::size_t row = rows_of_block() - 1; row-- > 0;) {
      for (std::size_t m = 0; m < column_moments; ++m) {
        add_row(block(row, m) + first, block(row + 1, m) + first, count);
      }
    }
    std::fill(begun_.begin(), begun_.end(), 0.0);
  }

  // The window's moments in each column, from the sums down it.
  static void spread(const std::array<double*, moments>& sums,
                     const std::array<const double*, column_moments>& ended,
                     const std::array<const double*, column_moments>& begun, const double* u,
                     std::ptrdiff_t count) {
    const auto moment = [&](double* __restrict out, ColumnMoment m, auto&& factor) {
      const double *const a = ended[m], *const b = begun[m];
      for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = factor(i) * (a[i] + b[i]);
    };
    const auto one = [](std::ptrdiff_t) { return 1.0; };
    const auto across = [u](std::ptrdiff_t i) { return u[i]; };
    const auto square = [u](std::ptrdiff_t i) { return u[i] * u[i]; };
    moment(sums[m_n], c_n, one);
    moment(sums[m_x], c_z, across);
    moment(sums[m_y], c_vz, one);
    moment(sums[m_z], c_z, one);
    moment(sums[m_xx], c_zz, square);
    moment(sums[m_xy], c_vzz, across);
    moment(sums[m_xz], c_zz, across);
    moment(sums[m_yy], c_vvzz, one);
    moment(sums[m_yz], c_vzz, one);
    moment(sums[m_zz], c_zz, one);
  }

  Camera<double> camera_;
  Index radius_ = 0, left_ = 0, right_ = 0, entered_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<double> columns_;  // rays, radius more on each side
  std::vector<double> block_;    // the last 2 radius + 1 rows that began at a multiple of as many
  std::vector<double> begun_;    // the sums over the rows of the block that is not full yet
  std::vector<double> down_, window_;  // moments of each column, and of each window
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::PlaneFitRows<float>;
GELIGHT_ONCE template class detail::PlaneFitRows<double>;
}  // namespace gelight
#endif
