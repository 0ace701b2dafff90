#pragma once

#include <concepts>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// The shortest line through portals laid out in one plane, from a place before the first to one
/// behind the last: what is seen through them is narrowed until it closes at an end of one, where
/// the line bends (Lee and Preparata 1984, doi:10.1002/net.3230140304). (A template only so that it
/// costs nothing to include.)
template <std::floating_point Real>
class TautLine {
 public:
  /// Forgets all, and begins at a place.
  void begin(const Vec2<Real>& place) {
    left_.assign(1, place);
    right_.assign(1, place);
  }
  /// Adds a portal, by its ends as they are seen on the way.
  void pass(const Vec2<Real>& left, const Vec2<Real>& right) {
    left_.push_back(left);
    right_.push_back(right);
  }

  /// The length of the line to a place. Linear in the portals, but for those that it bends at.
  [[nodiscard]] Real length_to(const Vec2<Real>& place) {
    pass(place, place);
    Real sum = 0;
    std::ptrdiff_t from = 0;
    const Array<Vec2<Real>>* side = &left_;  // on which the line bent last, at `from`
    while (from < std::ssize(left_) - 1) {
      const Vec2<Real> apex = (*side)[from];
      const auto [next, is_left] = next_bend(apex, from);
      side = is_left ? &left_ : &right_;
      sum += ((*side)[next] - apex).norm();
      from = next;
    }
    return sum;
  }

 private:
  struct Bend {
    std::ptrdiff_t portal;
    bool is_left;  // at its left end
  };

  // Where the line bends next, or ends, after the portal at which it bent last.
  [[nodiscard]] Bend next_bend(const Vec2<Real>& apex, std::ptrdiff_t from) const {
    const std::ptrdiff_t last = std::ssize(left_) - 1;
    std::ptrdiff_t left = from + 1, right = from + 1;  // the portals that bound what is seen
    for (std::ptrdiff_t i = from + 2; i <= last; ++i) {
      if (turn(apex, right_[right], right_[i]) >= 0) {
        if (right_[right] != apex && turn(apex, left_[left], right_[i]) >= 0) return {left, true};
        right = i;
      }
      if (turn(apex, left_[left], left_[i]) <= 0) {
        if (left_[left] != apex && turn(apex, right_[right], left_[i]) <= 0) return {right, false};
        left = i;
      }
    }
    return {last, true};
  }

  // Positive where the way from a by b to c turns left.
  static Real turn(const Vec2<Real>& a, const Vec2<Real>& b, const Vec2<Real>& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  }

  Array<Vec2<Real>> left_, right_;
};

}  // namespace gelight::detail
