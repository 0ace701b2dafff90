#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/marching/indexed_heap.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The shortest path along edges between two points, guided by what is left straight through space
/// (P. E. Hart, N. J. Nilsson, B. Raphael 1968, doi:10.1109/TSSC.1968.300136). A point that is no
/// vertex reaches those of its faces straight. Keeps its memory: a search takes time for the
/// vertices that it reaches alone.
template <std::floating_point Real>
class EdgeSearch {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;

  /// From one point to the other; empty where no path leads.
  [[nodiscard]] std::vector<Point> path(const Mesh& surface, const Point& from, const Point& to,
                                        const CancelHook& cancelled) {
    prepare(surface);
    const auto left = [&](Index v) { return straight_distance(surface, to, v); };
    const auto reach = [&](Index v, Real distance, Index before) {
      if (!(distance < distances_[v])) return;
      if (!(distances_[v] < unreachable<Real>)) reached_.push_back(v);
      distances_[v] = distance;
      before_[v] = before;
      heap_.push(v, distance + left(v));
    };
    ends_.clear();
    for_each_vertex_near(surface, to, [&](Index v, Real) { ends_.push_back(v); });
    for_each_vertex_near(surface, from, [&](Index v, Real d) { reach(v, d, none); });
    Real best = unreachable<Real>;
    Index last = none;
    for (std::ptrdiff_t pops = 0; !heap_.empty(); ++pops) {
      if (pops % pops_between_polls == 0) cancelled.check(0, "the search for a path");
      const Index v = heap_.pop();
      const Real rest = left(v);
      if (!(distances_[v] + rest < best)) break;
      if (std::find(ends_.begin(), ends_.end(), v) != ends_.end()) {
        best = distances_[v] + rest;
        last = v;
      }
      for (const Index out : surface.corners(v)) {
        const Index in = Mesh::previous(out);
        reach(surface.tip(out), distances_[v] + surface.length(out), v);
        reach(surface.origin(in), distances_[v] + surface.length(in), v);
      }
    }
    return last == none ? std::vector<Point>() : path_by(last, from, to);
  }

 private:
  static constexpr Index none = -1;
  static constexpr std::ptrdiff_t pops_between_polls = 4096;

  void prepare(const Mesh& surface) {
    if (std::ssize(distances_) != surface.vertex_count()) {
      const auto count = static_cast<std::size_t>(surface.vertex_count());
      distances_.assign(count, unreachable<Real>);
      before_.assign(count, none);
      heap_.reset(surface.vertex_count());
    }
    for (const Index v : reached_) distances_[v] = unreachable<Real>;
    reached_.clear();
    while (!heap_.empty()) heap_.pop();
  }

  [[nodiscard]] std::vector<Point> path_by(Index last, const Point& from, const Point& to) const {
    std::vector<Point> path{to};
    for (Index v = last; v != none; v = before_[v]) path.push_back(vertex_point<Real>(v));
    path.push_back(from);
    path.erase(std::unique(path.begin(), path.end()), path.end());
    std::reverse(path.begin(), path.end());
    return path;
  }

  Array<Real> distances_;  // of each vertex
  Array<Index> before_;    // of each vertex that was reached: the one before it, or none
  Array<Index> reached_, ends_;
  IndexedHeap<Real> heap_;
};

}  // namespace gelight::detail
