#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/lane.hpp"
#include "gelight/geodesic/exact/window_list.hpp"

namespace gelight::detail {

// A window goes when something else is shorter by more than rounding can pretend; here for squares.
inline constexpr double clearly_shorter = 1 - 1e-13;
// Of two windows that differ by rounding only, one is enough.
inline constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();

/// An edge and the distances known at its ends.
struct EdgeBounds {
  double length, at_origin, at_tip;
};

/// Drops every window all of whose points are reached sooner along the edge, from one of its ends.
/// It is enough to look at the far end of the window, since nothing grows faster along an edge than
/// the way along it (Xin, Wang 2009, doi:10.1145/1559755.1559761).
template <std::floating_point Real>
inline void drop_useless(const EdgeBounds& edge, WindowList<Real>& list) {
  const auto useless = [&](std::ptrdiff_t i) {
    const Lane begin = Lane::load(list.begin + i), end = Lane::load(list.end + i);
    const Lane x = Lane::load(list.x + i), y = Lane::load(list.y + i);
    const Lane start = Lane::load(list.start + i);
    const Lane by_origin = edge.at_origin + end - start;
    const Lane by_tip = edge.at_tip + (edge.length - begin) - start;
    const Lane to_end = (end - x) * (end - x) + y * y, to_begin = (begin - x) * (begin - x) + y * y;
    return (less(by_origin * abs(by_origin), to_end * clearly_shorter) |
            less(by_tip * abs(by_tip), to_begin * clearly_shorter)) &
           first_bits(list.size - i);
  };
  unsigned any = 0;
  for (std::ptrdiff_t i = 0; i < list.size; i += lane_size) any |= useless(i);
  if (any == 0) return;
  std::ptrdiff_t count = 0;
  for (std::ptrdiff_t i = 0; i < list.size; i += lane_size) {
    const unsigned those = useless(i);
    const std::ptrdiff_t end = std::min(i + lane_size, list.size);
    for (std::ptrdiff_t k = i; k < end; ++k) {
      if ((those >> (k - i) & 1) == 0) list.move(count++, k);
    }
  }
  list.size = count;
}

/// Drops every window through which no way is shorter than `bound`, given what way is left at least
/// from the edge's ends, `left`.
template <std::floating_point Real>
inline void drop_beyond(Real bound, const EdgeBounds& left, WindowList<Real>& list) {
  // From a point p of the edge at least the larger of left.at_origin - p and
  // left.at_tip - (length - p) is left. The way to p and on shrinks with p where the first is the
  // larger, since no way to p grows faster than p, and grows where the second is.
  const Real turn = (left.at_origin - left.at_tip + left.length) / 2;
  const auto way_to = [&](std::ptrdiff_t i, Real p) {
    return list.start[i] + std::hypot(p - list.x[i], list.y[i]);
  };
  std::ptrdiff_t count = 0;
  for (std::ptrdiff_t i = 0; i < list.size; ++i) {
    const Real p = std::clamp(turn, list.begin[i], list.end[i]);
    const Real rest = std::max(left.at_origin - p, left.at_tip - (left.length - p));
    const Real nearest = way_to(i, std::clamp(list.x[i], list.begin[i], list.end[i]));
    if (std::max(way_to(i, p) + rest, nearest) <= bound) list.move(count++, i);
  }
  list.size = count;
}

/// Puts the windows of a nearly sorted list in the order in which they lie on the edge, by their
/// middles.
template <std::floating_point Real>
inline void sort_windows(WindowList<Real>& list) {
  const auto middle = [&](std::ptrdiff_t i) { return list.begin[i] + list.end[i]; };
  unsigned unsorted = 0;
  for (std::ptrdiff_t i = 0; i + 1 < list.size; i += lane_size) {
    const Lane here = Lane::load(list.begin + i) + Lane::load(list.end + i);
    const Lane there = Lane::load(list.begin + i + 1) + Lane::load(list.end + i + 1);
    unsorted |= less(there, here) & first_bits(list.size - 1 - i);
  }
  if (unsorted == 0) return;
  for (std::ptrdiff_t i = 1; i < list.size; ++i) {
    if (!(middle(i) < middle(i - 1))) continue;
    const Real key = middle(i);
    std::ptrdiff_t place = i;
    list.move(list.size, i);  // there is room behind the last window
    for (; place > 0 && key < middle(place - 1); --place) list.move(place, place - 1);
    list.move(place, list.size);
  }
}

/// Of windows of a sorted list that see the same part of the edge from the same place, but for
/// `slack`, leaves the nearest.
template <std::floating_point Real>
inline void drop_repeated(Real slack, WindowList<Real>& list) {
  const auto are_near = [slack](Real a, Real b) { return std::fabs(a - b) <= slack; };
  const auto repeats = [&](std::ptrdiff_t i, std::ptrdiff_t k) {
    return are_near(list.begin[i], list.begin[k]) && are_near(list.end[i], list.end[k]) &&
           are_near(list.x[i], list.x[k]) && are_near(list.y[i], list.y[k]);
  };
  std::ptrdiff_t count = 0;
  for (std::ptrdiff_t i = 0; i < list.size; ++i) {
    std::ptrdiff_t k = count - 1;
    const Real middle = list.begin[i] + list.end[i] - 2 * slack;
    while (k >= 0 && list.begin[k] + list.end[k] >= middle && !repeats(i, k)) --k;
    const bool is_new = k < 0 || !repeats(i, k);
    if (is_new) {
      list.move(count++, i);
    } else if (list.start[i] < list.start[k]) {
      list.move(k, i);
    }
  }
  list.size = count;
}

/// Takes from each window of a sorted list the points that a neighbour reaches no later, so that
/// what is left hardly overlaps, as in Mitchell, Mount, Papadimitriou 1987
/// (doi:10.1137/0216045). A point is taken only where the neighbour keeps it: nothing is lost.
template <std::floating_point Real>
class WindowTrimmer {
 public:
  explicit WindowTrimmer(WindowList<Real>& list) : list_(list) {}

  void trim() {
    std::ptrdiff_t top = 0;
    bool is_untouched = true;  // the window at the top is as it was
    for (std::ptrdiff_t i = 1; i < list_.size; ++i) {
      if (is_untouched) {
        const std::ptrdiff_t count = first_to_part(i - 1) + 1 - i;
        if (top + 1 != i) list_.move(top + 1, i, count);
        top += count;
        i += count;
        if (i == list_.size) break;
      }
      const Real begin = list_.begin[i], end = list_.end[i];
      Verdict verdict = Verdict::keep;
      while (top >= 0) {
        verdict = part(top, i);
        if (verdict != Verdict::drop_left) break;
        --top;
      }
      is_untouched = verdict != Verdict::drop_right;
      if (!is_untouched) continue;
      is_untouched = begin == list_.begin[i] && end == list_.end[i];
      if (++top != i) list_.move(top, i);
    }
    list_.size = std::min(top + 1, list_.size);
  }

 private:
  enum class Verdict { keep, drop_left, drop_right };
  // Overlaps grow as windows travel, and do no harm: they wait until they are this share of the
  // narrower window. (Measured: at a half there are 0.5 % more windows than at a tenth, in up to an
  // eighth less time; where all of it may stay, there are twice as many.)
  static constexpr Real worth_parting = 0.5;
  // A gap of this share is rounding.
  static constexpr Real touching = 1e-12;

  // The first window from one on that `part` may have to do with, beside the next one; the last of
  // the list if there is none. Few are, so they are sought several at a time.
  [[nodiscard]] std::ptrdiff_t first_to_part(std::ptrdiff_t first) const {
    const std::ptrdiff_t last = list_.size - 1;
    for (std::ptrdiff_t i = first; i < last; i += lane_size) {
      const Lane begin_a = Lane::load(list_.begin + i), end_a = Lane::load(list_.end + i);
      const Lane begin_b = Lane::load(list_.begin + i + 1), end_b = Lane::load(list_.end + i + 1);
      const Lane overlap = min(end_a, end_b) - max(begin_a, begin_b);
      const Lane narrower = min(end_a - begin_a, end_b - begin_b);
      const Lane x = Lane::load(list_.x + i), y = Lane::load(list_.y + i);
      const Lane dx = x - Lane::load(list_.x + i + 1), dy = y - Lane::load(list_.y + i + 1);
      const Lane to_end = x - end_a;
      const unsigned overlaps = less(worth_parting * narrower, overlap);
      const unsigned are_apart =
          less(rounding * rounding * (to_end * to_end + y * y), dx * dx + dy * dy);
      const unsigned found = (overlaps | ~are_apart) & first_bits(last - i);
      if (found != 0) return i + std::countr_zero(found);
    }
    return last;
  }

  // Parts windows a and b, whose middle does not lie before that of a.
  Verdict part(std::ptrdiff_t a, std::ptrdiff_t b) {
    if (list_.origin[a] == list_.origin[b] && join(a, b)) return Verdict::drop_right;
    const Real low = std::max(list_.begin[a], list_.begin[b]);
    const Real high = std::min(list_.end[a], list_.end[b]);
    const Real narrower = std::min(list_.end[a] - list_.begin[a], list_.end[b] - list_.begin[b]);
    if (!(high - low > worth_parting * narrower)) return Verdict::keep;
    return list_.start[a] == list_.start[b] ? part_equal_starts(a, b, low, high)
                                            : part_by_distance(a, b, low, high);
  }

  // Windows with one image that touch or overlap are one window: they parted at a flat vertex.
  bool join(std::ptrdiff_t a, std::ptrdiff_t b) {
    const Real dx = list_.x[a] - list_.x[b], dy = list_.y[a] - list_.y[b];
    const Real to_end = list_.x[a] - list_.end[a], y = list_.y[a];
    if (!(dx * dx + dy * dy <= rounding * rounding * (to_end * to_end + y * y))) return false;
    const Real begin = std::min(list_.begin[a], list_.begin[b]);
    const Real end = std::max(list_.end[a], list_.end[b]);
    if (list_.begin[b] - list_.end[a] > touching * (end - begin)) return false;
    list_.begin[a] = begin;
    list_.end[a] = end;
    return true;
  }

  // With equal starts squares of distances tell as much, and their difference is linear.
  Verdict part_equal_starts(std::ptrdiff_t a, std::ptrdiff_t b, Real low, Real high) {
    const Real ax = list_.x[a], ay = list_.y[a], bx = list_.x[b], by = list_.y[b];
    const Real from_a = (ax - low) * (ax - low) + ay * ay;
    const Real at_low = (ax - bx) * ((ax - low) + (bx - low)) + (ay - by) * (ay + by);
    const Real slope = 2 * (bx - ax);
    const Real at_high = at_low + slope * (high - low);
    // Where images are apart, however little, windows keep what may be nearer by them; where that
    // is rounding, only what is.
    constexpr Real shorter = 1 - clearly_shorter;
    const Real farthest = std::max(from_a, (ax - high) * (ax - high) + ay * ay);
    const bool are_apart = slope * slope > shorter * shorter * farthest;
    const Real doubt = are_apart ? shorter * farthest : -2 * rounding * from_a;
    if (slope > 0 && at_low < doubt && at_high > -doubt) {
      const Real p = low - at_low / slope, room = std::max(doubt, Real(0)) / slope;
      return split_between(a, b, p - room, p + room);
    }
    return give_overlap(a, b, low, high, at_low <= -doubt && at_high <= -doubt,
                        at_low >= doubt && at_high >= doubt);
  }

  Verdict part_by_distance(std::ptrdiff_t a, std::ptrdiff_t b, Real low, Real high) {
    const Real a_low = distance_at(a, low), b_low = distance_at(b, low);
    const Real a_high = distance_at(a, high), b_high = distance_at(b, high);
    const Real tie = rounding * std::max(a_low, a_high);
    const Real at_low = a_low - b_low, at_high = a_high - b_high;
    if (at_low < -tie && at_high > tie) {
      return split(a, b, low, high, at_low, at_high);
    }
    // The difference has one extremum on the line, where both images lie in one direction.
    const Real turn =
        (list_.x[a] * list_.y[b] - list_.x[b] * list_.y[a]) / (list_.y[b] - list_.y[a]);
    const Real at_turn =
        turn > low && turn < high ? distance_at(a, turn) - distance_at(b, turn) : at_low;
    return give_overlap(a, b, low, high, at_low <= tie && at_high <= tie && at_turn <= tie,
                        at_low >= -tie && at_high >= -tie && at_turn >= -tie);
  }

  [[nodiscard]] Real distance_at(std::ptrdiff_t i, Real p) const {
    const Real dx = p - list_.x[i], dy = list_.y[i];
    return list_.start[i] + std::sqrt(dx * dx + dy * dy);
  }

  // One of the windows reaches the whole overlap no later than the other, which gives it up unless
  // that would cut it in two. Of equals the one that covers the other stays.
  Verdict give_overlap(std::ptrdiff_t a, std::ptrdiff_t b, Real low, Real high, bool a_wins,
                       bool b_wins) {
    const bool a_covers = list_.begin[a] <= list_.begin[b] && list_.end[a] >= list_.end[b];
    const bool b_covers = list_.begin[b] <= list_.begin[a] && list_.end[b] >= list_.end[a];
    if (a_wins && a_covers) return Verdict::drop_right;
    if (b_wins && b_covers) return Verdict::drop_left;
    if (a_wins || b_wins) {
      const std::ptrdiff_t loser = a_wins ? b : a;
      if (list_.begin[loser] == low) {
        list_.begin[loser] = high;
      } else if (list_.end[loser] == high) {
        list_.end[loser] = low;
      }
    }
    return Verdict::keep;
  }

  // Window a is nearer before p, b after it.
  Verdict split(std::ptrdiff_t a, std::ptrdiff_t b, Real p) { return split_between(a, b, p, p); }

  // The distances are equal on a branch of a hyperbola between low, where a is nearer, and high,
  // where b is: a few steps of the secant that keeps both sides (Illinois). What stays between is
  // left to both windows.
  Verdict split(std::ptrdiff_t a, std::ptrdiff_t b, Real low, Real high, Real at_low,
                Real at_high) {
    for (int step = 0; step < secant_steps; ++step) {
      const Real p = low - at_low * (high - low) / (at_high - at_low);
      if (!(p > low && p < high)) break;
      const Real at_p = distance_at(a, p) - distance_at(b, p);
      const bool is_a_nearer = at_p <= 0;  // as often as not: chosen without branching
      low = is_a_nearer ? p : low;
      high = is_a_nearer ? high : p;
      at_low = is_a_nearer ? at_p : at_low / 2;
      at_high = is_a_nearer ? at_high / 2 : at_p;
    }
    return split_between(a, b, low, high);
  }
  static constexpr int secant_steps = 2;  // a third saves 1 window of 5,000

  // Window a is not needed beyond `a_end`, nor b before `b_begin`, where the other one covers that.
  Verdict split_between(std::ptrdiff_t a, std::ptrdiff_t b, Real b_begin, Real a_end) {
    const bool a_covers = list_.begin[a] <= list_.begin[b];
    const bool b_covers = list_.end[b] >= list_.end[a];
    if (b_covers) list_.end[a] = std::min(list_.end[a], a_end);
    if (a_covers) list_.begin[b] = std::max(list_.begin[b], b_begin);
    if (!(list_.begin[a] < list_.end[a])) return Verdict::drop_left;
    if (!(list_.begin[b] < list_.end[b])) return Verdict::drop_right;
    return Verdict::keep;
  }

  WindowList<Real>& list_;
};

}  // namespace gelight::detail
