#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Where a path crosses an edge, passes a vertex, or begins or ends elsewhere.
template <std::floating_point Real>
struct PathMark {
  /// What `halfedge` is where no edge is crossed.
  static constexpr Index vertex = -1, begin = -2, end = -3;

  Index halfedge;  // that is crossed, in the face on the path's side towards its end
  Index other;     // in the face towards the source; or which vertex
  Real share;      // of the way along `halfedge`

  [[nodiscard]] bool is_crossing() const { return halfedge >= 0; }
};

/// A path as LineBacktrace follows it, from its end to its source, in marks.
template <std::floating_point Real>
class PathMarks {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using Mark = PathMark<Real>;

  explicit PathMarks(const Mesh& mesh) : mesh_(mesh) {}

  void clear() { marks_.clear(); }
  [[nodiscard]] std::ptrdiff_t size() const { return std::ssize(marks_); }
  /// Of the source 0, of the path's end size() - 1.
  [[nodiscard]] const Mark& operator[](std::ptrdiff_t i) const { return marks_[size() - 1 - i]; }

  /// What LineBacktrace calls.
  ///@{
  void to_vertex(Index vertex) {
    const bool is_there =
        !marks_.empty() && marks_.back().halfedge == Mark::vertex && marks_.back().other == vertex;
    if (!is_there) marks_.push_back({Mark::vertex, vertex, 0});
  }
  void over_edge(Index h, Index across, Real share) { marks_.push_back({h, across, share}); }
  void to_source(const Point& point) {
    begin_ = point;
    if (point.kind == Kind::vertex) return to_vertex(point.element[0]);
    marks_.push_back({Mark::begin, -1, 0});
  }
  [[nodiscard]] bool has(Index vertex) const {
    return std::any_of(marks_.begin(), marks_.end(), [&](const Mark& m) {
      return m.halfedge == Mark::vertex && m.other == vertex;
    });
  }
  ///@}

  /// The marks of a path from its source; false where a piece of it lies in no face.
  bool assign(std::span<const Point> path) {
    clear();
    begin_ = path.front();
    end_ = path.back();
    const auto last = std::ssize(path) - 1;
    Index before = -1;
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
      const Point& p = path[static_cast<std::size_t>(i)];
      Index after = before;
      if (i < last) after = common_face(p, path[static_cast<std::size_t>(i) + 1], before);
      if (after < 0) return false;
      if (p.kind == Kind::vertex) {
        marks_.push_back({Mark::vertex, p.element[0], 0});
      } else if (i == 0 || i == last) {
        marks_.push_back({i == 0 ? Mark::begin : Mark::end, -1, 0});
      } else {
        marks_.push_back(crossing(p, before, after));
      }
      before = after;
    }
    std::reverse(marks_.begin(), marks_.end());
    return true;
  }

  /// Where a mark lies.
  [[nodiscard]] Point point(const Mark& m) const {
    if (m.halfedge == Mark::begin) return begin_;
    if (m.halfedge == Mark::end) return end_;
    if (m.halfedge == Mark::vertex) return vertex_point<Real>(m.other);
    return edge_point<Real>(mesh_.origin(m.halfedge), mesh_.tip(m.halfedge), m.share);
  }

  /// The face of the piece from a mark to the next one, or -1.
  [[nodiscard]] Index face_after(std::ptrdiff_t i) const {
    const Mark &from = (*this)[i], &to = (*this)[i + 1];
    if (from.is_crossing()) return Mesh::face_of(from.halfedge);
    if (to.is_crossing()) return Mesh::face_of(to.other);
    return common_face(point(from), point(to), -1);
  }

 private:
  using Kind = typename Point::Kind;

  // A point of an edge, between two faces of a path.
  [[nodiscard]] Mark crossing(const Point& p, Index before, Index after) const {
    const Index h = edge(after, p);
    return {h, edge(before, p), p.weights[mesh_.origin(h) == p.element[0] ? 1 : 0]};
  }

  [[nodiscard]] Index edge(Index f, const Point& p) const {
    Index h = 3 * f;
    while (mesh_.apex(h) == p.element[0] || mesh_.apex(h) == p.element[1]) ++h;
    return h;
  }

  // A face that holds both points, or -1; beyond the edge by which the path came, where there is a
  // choice.
  [[nodiscard]] Index common_face(const Point& p, const Point& q, Index before) const {
    if (p.kind == Kind::face) return p.element[0];
    if (q.kind == Kind::face) return q.element[0];
    if (p.kind == Kind::edge && before >= 0) {
      const Index across = mesh_.twin(edge(before, p));
      if (holds(Mesh::face_of(across), q)) return Mesh::face_of(across);
    }
    for (const Index h : mesh_.corners(p.element[0])) {
      const Index f = Mesh::face_of(h);
      if (holds(f, p) && holds(f, q)) return f;
    }
    return -1;
  }
  [[nodiscard]] bool holds(Index f, const Point& p) const {
    const auto [a, b, c] = mesh_.face(f);
    const auto has = [&, a = a, b = b, c = c](Index v) { return a == v || b == v || c == v; };
    return has(p.element[0]) && (p.kind != Kind::edge || has(p.element[1]));
  }

  const Mesh& mesh_;
  Array<Mark> marks_;
  Point begin_, end_;  // where they are no vertices
};

}  // namespace gelight::detail
