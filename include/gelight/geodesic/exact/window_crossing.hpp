#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>

#include "gelight/core/array.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/lane.hpp"
#include "gelight/geodesic/exact/window_list.hpp"

namespace gelight::detail {

/// Where the straight line from (x, y), y < 0, to a point on or above the x axis crosses the axis.
template <std::floating_point Real>
[[nodiscard]] inline Real straight_crossing(Real x, Real y, Real to_x, Real to_y) {
  const Real height = to_y - y;
  return height > 0 ? x + (to_x - x) * (-y / height) : to_x;
}

/// Length of the shortest path from (x, y), y < 0, through the points begin to end of the x axis to
/// a point on or above it.
template <std::floating_point Real>
[[nodiscard]] inline Real distance_through(Real begin, Real end, Real x, Real y, Real to_x,
                                           Real to_y) {
  const Real straight = straight_crossing(x, y, to_x, to_y);
  const Real p = std::clamp(straight, begin, end);
  if (p == straight) return std::sqrt((to_x - x) * (to_x - x) + (to_y - y) * (to_y - y));
  return std::sqrt((p - x) * (p - x) + y * y) + std::sqrt((p - to_x) * (p - to_x) + to_y * to_y);
}

/// An image on an edge's line is kept this share of the length below it, far less than rounding, so
/// that no direction is lost.
inline constexpr double on_line = 1e-30;

/// Windows on a half-edge on their way across its face, which lies in the half-edge's frame with
/// its base from (0, 0) to (base, 0) and its apex above.
template <std::floating_point Real>
class FaceCrossing {
  using Columns = WindowColumns<Real>;
  using List = WindowList<Real>;

 public:
  /// The window by which the apex is nearest, and how its path there crosses the base.
  struct Nearest {
    Real distance = std::numeric_limits<Real>::infinity();
    std::ptrdiff_t window = -1;
    Real crossing = 0;
    bool is_straight = false;  // or bent at an end of the window
  };

  /// Aims every window of a list at the apex. No window is nearest where no distance is a number.
  Nearest aim(const List& list, Real base, const Vec2<Real>& apex) {
    base_ = base;
    apex_ = apex;
    size_ = list.size;
    const auto room = static_cast<std::size_t>(size_ + lane_size);
    if (aim_.size() < room) {
      aim_.resize(2 * room);
      distance_.resize(2 * room);
    }
    for (std::ptrdiff_t i = 0; i < size_; i += lane_size) {
      const Lane x = Lane::load(list.x + i), y = Lane::load(list.y + i);
      const Lane aim = x + (apex_.x() - x) * (y / (y - apex_.y()));
      const Lane p = min(max(aim, Lane::load(list.begin + i)), Lane::load(list.end + i));
      // Bent at p, which where the line is straight costs nothing but rounding.
      const Lane before = (p - x) * (p - x) + y * y;
      const Lane after = (apex_.x() - p) * (apex_.x() - p) + apex_.y() * apex_.y();
      aim.store(&aim_[i]);
      (Lane::load(list.start + i) + sqrt(before) + sqrt(after)).store(&distance_[i]);
    }
    nearest_ = {};
    for (std::ptrdiff_t i = 0; i < size_; ++i) {
      const bool is_nearer = distance_[i] < nearest_.distance;
      nearest_.distance = is_nearer ? distance_[i] : nearest_.distance;
      nearest_.window = is_nearer ? i : nearest_.window;
    }
    const std::ptrdiff_t n = nearest_.window;
    if (n < 0) return nearest_;
    nearest_.crossing = std::clamp(aim_[n], list.begin[n], list.end[n]);
    nearest_.is_straight = nearest_.crossing == aim_[n];
    return nearest_;
  }

  // One angle, two sides (Chen, Han 1990, doi:10.1145/98524.98601): let n be the window nearest the
  // apex and c a point of its path there, from the base to the apex. By another window w,
  // d_w(c) + |c - apex| >= d_w(apex) >= d_n(apex) = d_n(c) + |c - apex|, so no line through w that
  // crosses the path of n is a shortest one. Hence windows right of the path leave by the right
  // side only, and windows left of it by the left one.

  /// Which windows of the list may leave by the left side of the face, and which by the right.
  struct Sides {
    std::ptrdiff_t left_count = 0;   // at the start of the list
    std::ptrdiff_t right_begin = 0;  // from there to its end
  };
  [[nodiscard]] Sides sides(const List& list) const {
    Sides sides{0, size_};
    const Lane nearest(static_cast<Real>(nearest_.window)), crossing(nearest_.crossing);
    for (std::ptrdiff_t i = 0; i < size_; i += lane_size) {
      const Lane number = Lane(0, 1, 2, 3) + static_cast<Real>(i), aim = Lane::load(&aim_[i]);
      const Lane left_end = if_less(nearest, number, min(aim, crossing), aim);
      const Lane right_end = if_less(number, nearest, max(aim, crossing), aim);
      const unsigned windows = first_bits(size_ - i);
      const unsigned left = less(Lane::load(list.begin + i), left_end) & windows;
      const unsigned right = less(right_end, Lane::load(list.end + i)) & windows;
      if (left != 0) sides.left_count = i + static_cast<int>(std::bit_width(left));
      const bool is_first = right != 0 && sides.right_begin == size_;
      if (is_first) sides.right_begin = i + std::countr_zero(right);
    }
    return sides;
  }

  // A window that passes the apex leaves up to the side's end. That is not computed: where the
  // image lies on the base's line, how far the aim is from the image is lost in rounding.

  /// Windows [0, count) of the list as they leave by the left side of the face, of a given length,
  /// in the frame from the base's origin to the apex. Returns how many there are.
  [[nodiscard]] std::ptrdiff_t cross_left(const List& list, std::ptrdiff_t count, Real length,
                                          const Columns& out) const {
    const Real ax = apex_.x(), ay = apex_.y(), norm = std::sqrt(ax * ax + ay * ay);
    const Real ux = ax / norm, uy = ay / norm;
    bool are_windows = true;
    for (std::ptrdiff_t i = 0; i < count; i += lane_size) {
      const Lane x = Lane::load(list.x + i), y = Lane::load(list.y + i), aim = Lane::load(&aim_[i]);
      const Lane from = Lane::load(list.begin + i), to = Lane::load(list.end + i);
      const auto share = [&](Lane p) {
        return min(max((y * p) / (ax * y - ay * (x - p)), 0.0), 1.0);
      };
      const Lane begin = share(min(from, aim)) * length;
      const Lane whole = if_less(from, aim, length, 0.0);
      const Lane end = if_less(to, aim, share(min(to, aim)) * length, whole);
      begin.store(out.begin + i);
      end.store(out.end + i);
      (ux * x + uy * y).store(out.x + i);
      min(ux * y - uy * x, -on_line * length).store(out.y + i);
      are_windows &= are_all_windows(end - begin, length, count - i);
    }
    std::copy_n(list.origin, count, out.origin);
    if (is_doubtful(length)) {
      close_before(count, length, out,
                   [&](std::ptrdiff_t i) { return ux * list.y[i] - uy * list.x[i]; });
      are_windows = false;
    }
    return are_windows ? count : compact(count, length, out);
  }

  /// Windows [first, size) of the list as they leave by the right side of the face, of a given
  /// length, in the frame from the apex to the base's tip; given the apex as seen from there, back
  /// along the base and up. Returns how many there are.
  [[nodiscard]] std::ptrdiff_t cross_right(const List& list, std::ptrdiff_t first, Real length,
                                           const Vec2<Real>& apex_from_tip,
                                           const Columns& out) const {
    const Real ax = apex_from_tip.x(), ay = apex_from_tip.y();
    const Real norm = std::sqrt(ax * ax + ay * ay), ux = ax / norm, uy = ay / norm;
    bool are_windows = true;
    for (std::ptrdiff_t i = first; i < size_; i += lane_size) {
      const std::ptrdiff_t o = i - first;
      const Lane x = base_ - Lane::load(list.x + i), y = Lane::load(list.y + i);
      const Lane aim = Lane::load(&aim_[i]);
      const Lane from = Lane::load(list.begin + i), to = Lane::load(list.end + i);
      const auto share = [&](Lane position) {
        const Lane p = base_ - position;
        return min(max((y * p) / (ax * y - ay * (x - p)), 0.0), 1.0);
      };
      const Lane whole = if_less(aim, to, 0.0, length);
      const Lane begin = if_less(aim, from, length - share(max(from, aim)) * length, whole);
      const Lane end = length - share(max(to, aim)) * length;
      begin.store(out.begin + o);
      end.store(out.end + o);
      (length - (ux * x + uy * y)).store(out.x + o);
      min(ux * y - uy * x, -on_line * length).store(out.y + o);
      are_windows &= are_all_windows(end - begin, length, size_ - i);
    }
    const std::ptrdiff_t count = size_ - first;
    std::copy_n(list.origin + first, count, out.origin);
    if (is_doubtful(length)) {
      close_before(count, length, out, [&](std::ptrdiff_t o) {
        return ux * list.y[first + o] - uy * (base_ - list.x[first + o]);
      });
      are_windows = false;
    }
    return are_windows ? count : compact(count, length, out);
  }

 private:
  // A window of fewer units in the last place is no window.
  static constexpr Real narrow = 4 * std::numeric_limits<Real>::epsilon();

  // Whether it is rounding on which side of the apex a line passes: where that is next to an end of
  // the base, at a side of this length, or where the base is next to nothing as seen from the
  // images. (Those of a list are about as far as each other.)
  [[nodiscard]] bool is_doubtful(Real length) const {
    constexpr Real far = 64 * std::numeric_limits<Real>::epsilon();
    return length < next_to_vertex * base_ || base_ < far * nearest_.distance;
  }

  // Closes the windows on such a side whose images lie before it, by a height above it that is no
  // rounding: lines from there do not cross it.
  void close_before(std::ptrdiff_t count, Real length, const Columns& out,
                    const auto& height) const {
    constexpr Real rounding = 64 * std::numeric_limits<Real>::epsilon();
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      if (height(i) > rounding * (std::fabs(out.x[i]) + base_ + length)) out.end[i] = out.begin[i];
    }
  }

  // Whether the next four are windows on a side of this length, given their widths, or as many of
  // them as are left.
  static bool are_all_windows(Lane width, Real length, std::ptrdiff_t left) {
    const unsigned windows = first_bits(left);
    return (less(narrow * length, width) & windows) == windows;
  }

  // Drops what is no window.
  static std::ptrdiff_t compact(std::ptrdiff_t count, Real length, const Columns& out) {
    std::ptrdiff_t kept = 0;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      if (!(out.end[i] - out.begin[i] > narrow * length)) continue;
      if (kept != i) out.copy(kept, out, i);
      ++kept;
    }
    return kept;
  }

  Real base_ = 0;
  Vec2<Real> apex_{0, 0};
  std::ptrdiff_t size_ = 0;
  Nearest nearest_;
  Array<Real> aim_;       // where on the base the line from each image to the apex crosses it
  Array<Real> distance_;  // of the apex through each window
};

}  // namespace gelight::detail
