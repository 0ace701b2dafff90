#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/views/image_view.hpp"

// Springs under an object, row by row, in plain loops that compilers vectorise.
namespace gelight::detail {

/// Three by three numbers in double. (By T, so that nothing is compiled unused.)
template <std::floating_point T>
using DoubleMatrix3 = Eigen::Matrix<std::common_type_t<T, double>, 3, 3>;

/// The object over one row of springs: between which columns it is, and its least gap.
struct SpringRow {
  Index begin = 0, end = 0;
  double least = std::numeric_limits<double>::infinity();
};

/// How an object moves towards the gel: by `offset` at column and row 0, and so much more with
/// every column and row.
struct RigidMotion {
  double offset = 0, per_column = 0, per_row = 0;

  [[nodiscard]] double at(Index x, Index y) const { return offset + per_column * x + per_row * y; }
  [[nodiscard]] bool is_none() const { return offset == 0 && per_column == 0 && per_row == 0; }
};

/// What springs bear in units of a spring's stiffness, with moments in columns (x) and rows (y);
/// and the number of those that the object touches, with the sums over their columns and rows.
struct SpringSums {
  double load = 0, x_load = 0, y_load = 0;
  double count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

// Reductions go into eight lanes side by side, so that they are vectorised.
inline constexpr Index spring_lanes = 8;

template <class T>
[[nodiscard]] T least_of_row(const T* row, Index count) {
  std::array<T, spring_lanes> least;
  least.fill(std::numeric_limits<T>::infinity());
  Index x = 0;
  for (; x + spring_lanes <= count; x += spring_lanes) {
    for (std::size_t lane = 0; lane < spring_lanes; ++lane) {
      const T value = row[x + static_cast<Index>(lane)];
      least[lane] = value < least[lane] ? value : least[lane];
    }
  }
  for (; x < count; ++x) least[0] = std::min(least[0], row[x]);
  return *std::min_element(least.begin(), least.end());
}

/// Writes the distances between object and gel; +infinity where there is no object, or none known.
/// Returns how many are not known.
template <class T, class D>
[[nodiscard]] Index read_gap_row(T* __restrict gap, const D& depth, Index y, T rest, Index width) {
  constexpr T inf = std::numeric_limits<T>::infinity();
  Index unknown = 0;
  for (Index x = 0; x < width; ++x) {
    const T z = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
    gap[x] = z > 0 ? z - rest : inf;
    unknown += z > 0 ? 0 : 1;
  }
  return unknown;
}

template <class T, class D>
[[nodiscard]] Index read_gaps(Image<T>& gap, Array<SpringRow>& rows, const D& depth, T rest) {
  constexpr T inf = std::numeric_limits<T>::infinity();
  const Index width = gap.width();
  Index unknown = 0;
  for (Index y = 0; y < gap.height(); ++y) {
    T* const line = gap.row(y);
    unknown += read_gap_row(line, depth, y, rest, width);
    const T least = least_of_row(line, width);
    if (least == inf) continue;
    SpringRow& row = rows[static_cast<std::size_t>(y)];
    row = {0, width, double{least}};
    while (line[row.begin] == inf) ++row.begin;
    while (line[row.end - 1] == inf) --row.end;
  }
  return unknown;
}

/// Turns the gaps of a row into indentations.
template <class T>
void press_row(T* __restrict gap, std::uint8_t* __restrict touching, double first,
               double per_column, Index width) {
  for (Index x = 0; x < width; ++x) {
    const double u = first + per_column * x - static_cast<double>(gap[x]);
    gap[x] = u > 0 ? static_cast<T>(u) : T(0);
    touching[x] = u > 0 ? 1 : 0;
  }
}

template <class T>
void press_rows(Image<T>& gap, Image<std::uint8_t>& touching, const RigidMotion& motion) {
  for (Index y = 0; y < gap.height(); ++y) {
    press_row(gap.row(y), touching.row(y), motion.at(0, y), motion.per_column, gap.width());
  }
}

template <bool tilts, class T>
void add_spring_row(SpringSums& sums, const T* gap, const SpringRow& row, Index y,
                    const RigidMotion& motion) {
  using Lanes = std::array<double, spring_lanes>;
  Lanes count{}, columns{}, squares{}, load{}, x_load{};
  const double base = motion.at(0, y), per_column = motion.per_column;
  const auto add = [&](Index x, std::size_t lane) {
    const double column = x;
    const double u = base + (tilts ? per_column * column : 0) - static_cast<double>(gap[x]);
    const double one = u > 0 ? 1.0 : 0.0, in = u > 0 ? u : 0.0;
    count[lane] += one;
    load[lane] += in;
    if constexpr (tilts) {
      columns[lane] += one * column;
      squares[lane] += one * column * column;
      x_load[lane] += in * column;
    }
  };
  Index x = row.begin;
  for (; x + spring_lanes <= row.end; x += spring_lanes) {
    for (Index lane = 0; lane < spring_lanes; ++lane) add(x + lane, static_cast<std::size_t>(lane));
  }
  for (; x < row.end; ++x) add(x, 0);
  const auto total = [](const Lanes& l) {
    return ((l[0] + l[4]) + (l[1] + l[5])) + ((l[2] + l[6]) + (l[3] + l[7]));
  };
  const double n = total(count), pressed = total(load);
  sums.count += n;
  sums.load += pressed;
  if constexpr (tilts) {
    const double across = total(columns);
    sums.x_load += total(x_load);
    sums.y_load += pressed * y;
    sums.x += across;
    sums.y += n * y;
    sums.xx += total(squares);
    sums.xy += across * y;
    sums.yy += n * y * y;
  }
}

template <bool tilts, class T>
[[nodiscard]] SpringSums sum_spring_rows(const Image<T>& gap, const Array<SpringRow>& rows,
                                         const RigidMotion& motion, Index step) {
  SpringSums sums;
  for (Index y = 0; y < gap.height(); y += step) {
    const SpringRow& row = rows[static_cast<std::size_t>(y)];
    const double most = std::max(motion.at(row.begin, y), motion.at(row.end, y));
    if (most > row.least) add_spring_row<tilts>(sums, gap.row(y), row, y, motion);
  }
  return sums;
}

/// A rigid object above springs that stand each on its own.
template <class T>
class LoneSprings {
 public:
  /// To which share of the load sums are exact.
  static constexpr double accuracy = 1e-14;

  /// Uses `gap` for the distances between object and gel; `press` turns them into indentations.
  template <class D>
  LoneSprings(Image<T>& gap, const D& depth, T rest)
      : gap_(gap), rows_(static_cast<std::size_t>(gap.height())) {
    unknown_ = vectorised([&] { return read_gaps(gap, rows_, depth, rest); });
    for (const SpringRow& row : rows_) least_ = std::min(least_, row.least);
  }

  [[nodiscard]] Index unknown() const { return unknown_; }
  [[nodiscard]] const Array<SpringRow>& rows() const { return rows_; }
  [[nodiscard]] double gap(Index x, Index y) const { return static_cast<double>(gap_(x, y)); }
  [[nodiscard]] double least_gap() const { return least_; }

  /// How many springs bear at most.
  [[nodiscard]] double most() const {
    double count = 0;
    for (const SpringRow& row : rows_) count += row.end - row.begin;
    return count;
  }
  /// What one bears at most by its own displacement and its neighbours', over that.
  [[nodiscard]] static double stiffest() { return 1; }
  /// The load that is looked for. Sums are exact in any case.
  static void expect(double) {}
  /// Whether the last sums are those of an equilibrium of the springs.
  [[nodiscard]] static bool is_settled() { return true; }

  /// How the load along each of some motions grows with each of them. They are orthonormal, or
  /// none, over the springs that are touched.
  [[nodiscard]] static DoubleMatrix3<T> resistance(const std::array<RigidMotion, 3>& /*motions*/) {
    return DoubleMatrix3<T>::Identity();
  }

  /// The sums over every `step`-th row.
  [[nodiscard]] SpringSums sums(const RigidMotion& motion, bool tilts, Index step = 1) const {
    return vectorised([&] {
      return tilts ? sum_spring_rows<true>(gap_, rows_, motion, step)
                   : sum_spring_rows<false>(gap_, rows_, motion, step);
    });
  }

  /// How far a motion takes the object into the gel at most.
  [[nodiscard]] double deepest(const RigidMotion& motion) const {
    if (motion.per_column == 0 && motion.per_row == 0) return motion.offset - least_;
    double most = -std::numeric_limits<double>::infinity();
    for (Index y = 0; y < gap_.height(); ++y) {
      const SpringRow& row = rows_[static_cast<std::size_t>(y)];
      for (Index x = row.begin; x < row.end; ++x) {
        most = std::max(most, motion.at(x, y) - gap(x, y));
      }
    }
    return most;
  }

  void press(Image<std::uint8_t>& touching, const RigidMotion& motion) {
    vectorised([&] { press_rows(gap_, touching, motion); });
  }

 private:
  Image<T>& gap_;
  Array<SpringRow> rows_;
  double least_ = std::numeric_limits<double>::infinity();
  Index unknown_ = 0;
};

/// Whether a point (in columns and rows) lies in the convex hull of the springs under the object,
/// or beside it by no more than it may be rounded by.
[[nodiscard]] inline bool is_under_object(const Array<SpringRow>& rows, double x, double y) {
  constexpr double beside = 1e-9;  // of a pixel
  // Of all chords between a row above the point and one below, how far the outermost lies out.
  const auto outermost = [&](auto&& side) {
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < rows.size(); ++a) {
      const double above = y - static_cast<double>(a);
      if (rows[a].begin == rows[a].end || above < -beside) continue;
      for (std::size_t b = a; b < rows.size(); ++b) {
        const double below = static_cast<double>(b) - y;
        if (rows[b].begin == rows[b].end || below < -beside) continue;
        const double share = b > a ? std::clamp(above / (above + below), 0.0, 1.0) : 0;
        most = std::max(most, (1 - share) * side(rows[a]) + share * side(rows[b]));
      }
    }
    return most;
  };
  const double left = outermost([](const SpringRow& row) { return -double{1} * row.begin; });
  const double right = outermost([](const SpringRow& row) { return double{1} * (row.end - 1); });
  return -left - beside <= x && x <= right + beside;
}

}  // namespace gelight::detail
