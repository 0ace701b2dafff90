#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Lower bounds of the distance from any potential with a value per vertex.
///
/// Between its vertices the potential is not linear but what a distance in the plane is: in each
/// face F^2 = |x - c|^2 + k, which on an edge depends on the values at its ends alone, so F is
/// continuous. At level F = t its gradient is sqrt(t^2 - k) / t: at most 1 where k >= 0. Of every
/// path from the source to level t at least the integral of t / sqrt(t^2 + K(t)) is its length,
/// where K(t) is the largest -k of the faces that have points at that level: a bad face costs at
/// its own levels only. A face (almost) without area is taken for its longest edge; that costs what
/// F differs by across it, once, since a shortest path crosses a face once.
template <std::floating_point Real>
class LowerPotential {
 public:
  LowerPotential(const Surface<Real>& surface, const PlanarFaces<Real>& faces)
      : surface_(surface), faces_(faces) {}

  /// Of each vertex, at least `-inf` and +infinity where `potential` is; that is finite, not
  /// negative, or +infinity where no path leads. Rounding is on the safe side. The sources' start
  /// distances and the potential both count from the least start distance. Linear time.
  [[nodiscard]] Array<Real> bounds(const Array<Real>& potential,
                                   const Array<Source<Real>>& sources) const {
    Levels levels = levels_of(potential);
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto [a, b, c] = surface_.face(f);
      if (potential[a] < unreachable<Real>) levels.add(steepness(f, potential));
    }
    levels.integrate();
    double start = unreachable<Real>;
    for (const auto& source : sources) {
      const double level = level_at(source.point, potential);
      if (level < unreachable<Real>) {
        start = std::min(start, source.distance - levels.at_most(level));
      }
    }
    Array<Real> out;
    out.reserve(potential.size());
    for (const double level : potential) {
      out.push_back(level < unreachable<Real> ? levels.at_least(level) + start : level);
    }
    return out;
  }

  /// Lowers the potential, vertex after vertex away from the sources, to what the nearer vertices
  /// of its faces allow for k >= 0. Where faces are not very obtuse that leaves few with k < 0.
  [[nodiscard]] Array<Real> lowered(Array<Real> potential) const {
    const Index count = surface_.vertex_count();
    std::vector<std::pair<Real, Index>> order;
    order.reserve(potential.size());
    for (Index v = 0; v < count; ++v) order.emplace_back(potential[v], v);
    std::sort(order.begin(), order.end());
    Array<Index> rank(potential.size());
    for (Index i = 0; i < count; ++i) rank[order[static_cast<std::size_t>(i)].second] = i;
    for (const auto& [level, v] : order) {
      if (!(level < unreachable<Real>)) break;
      for (const Index h : surface_.corners(v)) {
        const Index a = surface_.tip(h), b = surface_.apex(h);
        const bool after_a = rank[a] < rank[v], after_b = rank[b] < rank[v];
        if (after_a) lower(v, potential[a] + surface_.length(h), potential);
        if (after_b) lower(v, potential[b] + surface_.length(Mesh::previous(h)), potential);
        if (after_a && after_b) lower(v, across(Mesh::next(h), potential), potential);
      }
    }
    return potential;
  }

 private:
  using Mesh = Surface<Real>;
  static constexpr double epsilon = std::numeric_limits<Real>::epsilon();
  // A face is taken for its longest edge where that is so many times as good, and only if the face
  // loses more than this share of its range.
  static constexpr double clearly_better = 10, least_loss = 0.01;
  static constexpr double levels_per_face = 4;
  static constexpr double most_levels = 1 << 20;

  /// What a face does to paths between its lowest and highest level: K, and a jump.
  struct Steepness {
    double lowest, highest;
    double excess;    // K: the gradient is at most sqrt(1 + K / t^2)
    double jump = 0;  // what F may differ by beyond that

    [[nodiscard]] double loss() const {
      return jump + highest - lowest - gain(lowest, highest, excess);
    }
  };

  // The integral of t / sqrt(t^2 + K) from a to b.
  static double gain(double a, double b, double excess) {
    if (!(b > a)) return 0;
    if (excess == 0) return b - a;
    return (b - a) * (b + a) / (std::sqrt(b * b + excess) + std::sqrt(a * a + excess));
  }

  /// Levels in steps, with the largest K of each and the jumps that begin in it.
  class Levels {
   public:
    Levels(double top, double step)
        : step_(step),
          excess_(static_cast<std::size_t>(top / step) + 2, 0),
          jump_(excess_.size(), 0) {}

    void add(const Steepness& face) {
      const Index first = number(face.lowest), last = number(face.highest);
      for (Index i = first; i <= last; ++i) excess_[i] = std::max(excess_[i], face.excess);
      jump_[first] += face.jump;
    }

    void integrate() {
      gained_.assign(excess_.size(), 0);
      jumped_.assign(excess_.size(), 0);
      double gained = 0, jumped = 0;
      for (Index i = 0; i < std::ssize(excess_); ++i) {
        gained_[i] = gained;
        jumped_[i] = jumped += jump_[i];
        gained += gain(step_ * i, step_ * (i + 1), excess_[i]);
      }
      rounding_ = 4 * epsilon * static_cast<Real>(excess_.size() + 16);
    }

    // The integral up to a level, rounded up, and down less the jumps.
    [[nodiscard]] double at_most(double level) const { return integral(level) * (1 + rounding_); }
    [[nodiscard]] double at_least(double level) const {
      return integral(level) * (1 - rounding_) - jumped_[number(level)] * (1 + rounding_);
    }

   private:
    [[nodiscard]] Index number(double level) const {
      // Clamped first: infinite levels, where no distance is known, are no Index.
      const auto last = static_cast<double>(excess_.size() - 1);
      return static_cast<Index>(std::min(last, std::max(0.0, level / step_)));
    }
    [[nodiscard]] double integral(double level) const {
      const Index i = number(level);
      return gained_[i] + gain(step_ * i, level, excess_[i]);
    }

    double step_, rounding_ = 0;
    Array<Real> excess_, jump_, gained_, jumped_;
  };

  [[nodiscard]] Levels levels_of(const Array<Real>& potential) const {
    double top = 0, ranges = 0;
    Index faces = 0;
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto [a, b, c] = surface_.face(f);
      const auto [low, high] = std::minmax({potential[a], potential[b], potential[c]});
      if (!(high < unreachable<Real>)) continue;
      top = std::max(top, high);
      ranges += high - low;
      ++faces;
    }
    const double step = ranges / (levels_per_face * std::max(Index{1}, faces));
    const double least = top / most_levels;
    return {top, std::max({step, least, std::numeric_limits<Real>::min()})};
  }

  [[nodiscard]] Steepness steepness(Index f, const Array<Real>& potential) const {
    Index h = 3 * f;
    for (Index g = 3 * f + 1; g < 3 * f + 3; ++g) {
      if (surface_.length(g) > surface_.length(h)) h = g;
    }
    const double length = surface_.length(h);
    const double fu = potential[surface_.origin(h)], fw = potential[surface_.tip(h)],
                 fv = potential[surface_.apex(h)];
    const double highest = std::max({fu, fw, fv}), lowest_corner = std::min({fu, fw, fv});
    if (length == 0) return {lowest_corner, highest, 0, highest - lowest_corner};
    const double to_u = surface_.length(Mesh::previous(h)), to_w = surface_.length(Mesh::next(h));
    const Vec2<Real> at = faces_.apex(h);

    // The centre's foot on the longest edge, its squared distance from there, and how much larger
    // F^2 there is at the apex' foot than it would have to be for the centre to be on the edge.
    const double spread = (fu - fw) * (fu + fw) / length;
    const double foot = (length + spread) / 2;
    const double foot_error = 4 * epsilon * (length + std::abs(spread));
    const double depth2 = (fu - foot) * (fu + foot);
    const bool near_u = to_u < to_w;
    const double from_near = near_u ? at.x() : length - at.x();
    const double foot_near = near_u ? foot : length - foot;
    const double f_near = near_u ? fu : fw, to_near = near_u ? to_u : to_w;
    const double difference = (f_near - fv) * (f_near + fv);
    const double fall = difference + to_near * to_near - 2 * foot_near * from_near;
    const double fall_error =
        8 * epsilon *
            (std::abs(difference) + to_near * to_near + 2 * std::abs(foot_near * from_near)) +
        2 * foot_error * std::abs(from_near) + 8 * epsilon * to_near * std::abs(foot_near);
    const double squares_error =
        8 * epsilon * (fu * fu + foot * foot) + 2 * std::abs(foot) * foot_error;

    const double edge_low = std::min(
        {edge_lowest(fu, fw, length), edge_lowest(fu, fv, to_u), edge_lowest(fw, fv, to_w)});
    Steepness as_edge{edge_low, highest, std::max(0.0, -depth2) + squares_error};
    const double off = std::max(std::abs(at.y() * at.y() - fall), std::abs(fall)) + fall_error +
                       8 * epsilon * highest * highest;
    const double least = std::max(0.0, (fu + fw - length) / 2);
    as_edge.jump = 2 * std::min(std::sqrt(off), least > 0 ? off / least : unreachable<Real>);
    if (!(at.y() > 0)) return as_edge;

    const double centre = fall / (2 * at.y());
    const double height_error = 8 * epsilon * to_u * to_w / length;
    const double centre_error =
        fall_error / (2 * at.y()) + std::abs(centre) * height_error / at.y();
    const double k = depth2 - centre * centre;
    const double k_error = squares_error + 8 * epsilon * centre * centre +
                           (2 * std::abs(centre) + centre_error) * centre_error;
    // Where the centre may be inside, F falls to its value there.
    const bool may_hold_centre = foot >= 0 && foot <= length && centre >= 0 && centre <= at.y();
    const double lowest =
        may_hold_centre ? std::min(edge_low, std::sqrt(std::max(0.0, k - k_error))) : edge_low;
    const Steepness as_face{lowest, highest, std::max(0.0, k_error - k)};
    const double loss = as_face.loss();
    const bool is_bad = !(loss <= least_loss * (highest - lowest));
    return is_bad && clearly_better * as_edge.loss() < loss ? as_edge : as_face;
  }

  // The least F on an edge with these values at its ends.
  static double edge_lowest(double a, double b, double length) {
    const double least = std::min(a, b);
    if (!(length > std::abs((a - b) * (a + b)) / length)) return least;  // the foot is outside
    const double foot = (length + (a - b) * (a + b) / length) / 2;
    return std::sqrt(
        std::max(0.0, (a - foot) * (a + foot) * (1 - 8 * epsilon) - 8 * epsilon * length * length));
  }

  // F at a point, rounded up.
  [[nodiscard]] double level_at(const SurfacePoint<Real>& point,
                                const Array<Real>& potential) const {
    using Kind = typename SurfacePoint<Real>::Kind;
    const auto& [a, b] = point.element;
    const auto& w = point.weights;
    if (point.kind == Kind::vertex) return potential[a];
    std::array<Index, 3> v{a, b, b};
    if (point.kind == Kind::face) v = surface_.face(a);
    double squared = 0, size = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      squared += w[i] * potential[v[i]] * potential[v[i]];
      for (std::size_t j = 0; j < i; ++j) {
        const double length = stable_norm(surface_.position(v[i]) - surface_.position(v[j]));
        squared -= w[i] * w[j] * length * length;
        size += w[i] * w[j] * length * length;
      }
    }
    // The weights' sum is 1 within 16 epsilon.
    return std::sqrt(std::max(0.0, squared) + 64 * epsilon * (std::abs(squared) + size));
  }

  static void lower(Index v, double level, Array<Real>& potential) {
    potential[v] = std::min(potential[v], level);
  }

  // How far the apex is from the place that has the right distances from a half-edge's ends.
  [[nodiscard]] double across(Index h, const Array<Real>& potential) const {
    const double length = surface_.length(h);
    const double a = potential[surface_.origin(h)], b = potential[surface_.tip(h)];
    if (!(length > 0)) return unreachable<Real>;
    const double foot = (length + (a - b) * (a + b) / length) / 2;
    const double squared = (a - foot) * (a + foot);
    if (!(squared >= 0)) return unreachable<Real>;
    const Vec2<Real> at = faces_.apex(h);
    const double aside = at.x() - foot, above = at.y() + std::sqrt(squared);
    return std::sqrt(aside * aside + above * above);
  }

  const Surface<Real>& surface_;
  const PlanarFaces<Real>& faces_;
};

}  // namespace gelight::detail
