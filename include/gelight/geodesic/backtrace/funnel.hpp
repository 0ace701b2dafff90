#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// The shortest line through portals laid out in one plane, from a place before the first to one
/// behind the last: what is seen through them is narrowed until it closes at an end of one, where
/// the line bends (Lee and Preparata 1984, doi:10.1002/net.3230140304).
template <std::floating_point Real>
class Funnel {
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
    bends_.assign(1, {0, true});
    while (bends_.back().portal < std::ssize(left_) - 1) {
      const Vec2<Real> apex = at(bends_.back());
      bends_.push_back(next_bend(apex, bends_.back().portal));
      sum += norm(at(bends_.back()) - apex);
    }
    return sum;
  }

  /// Where the line of the last length_to crosses the portals, in their order: shares of the way
  /// from their left ends to their right ends.
  [[nodiscard]] Array<Real> crossings() const {
    Array<Real> shares;
    for (std::ptrdiff_t b = 1; b < std::ssize(bends_); ++b) {
      const Vec2<Real> from = at(bends_[b - 1]), to = at(bends_[b]);
      for (auto i = bends_[b - 1].portal + 1; i < bends_[b].portal; ++i) {
        const Real left = turn(from, to, left_[i]), right = turn(from, to, right_[i]);
        // Between two bends at one place, that is the end of all portals there.
        const Real at_bend = from == to && !bends_[b].is_left ? 1 : 0;
        shares.push_back(left > right ? std::clamp(left / (left - right), Real(0), Real(1))
                                      : at_bend);
      }
      if (b + 1 < std::ssize(bends_)) shares.push_back(bends_[b].is_left ? 0 : 1);
    }
    return shares;
  }

 private:
  struct Bend {
    std::ptrdiff_t portal;
    bool is_left;  // at its left end
  };

  [[nodiscard]] const Vec2<Real>& at(const Bend& bend) const {
    return bend.is_left ? left_[bend.portal] : right_[bend.portal];
  }

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
  Array<Bend> bends_;  // of the last line, its ends among them
};

}  // namespace gelight::detail
