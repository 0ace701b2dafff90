#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/smooth/curved_faces.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What is found of a path on the smooth surface.
template <std::floating_point Real>
struct LiftedLength {
  Real length = 0;       ///< of the path as it was on the mesh, lifted
  Real gain = 0;         ///< by which it is shorter where it goes straightest, to second order
  Real roughness = 0;    ///< how unlike a smooth surface it runs: 0 to 1 and more
  bool is_least = true;  ///< no path beside it is shorter but for that
  Vec3<Real> direction{0, 0, 0};  ///< unit tangent on arrival

  [[nodiscard]] Real shortest() const { return is_least ? length - gain : length; }
};

/// Puts a shortest path of the mesh onto the smooth surface over it, lets it move sideways along
/// the edges that it crosses until it is straight there, by one Newton step, and measures it.
///
/// Where faces of size h turn by k h, the lifted path is as long as the smooth one but for (k h)^3,
/// relative, and but for about (k h)^4 where it is let move, while a mesh is off by (k h)^2.
template <std::floating_point Real>
class LiftedPath {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;

  explicit LiftedPath(const CurvedFaces<Real>& faces) : faces_(faces), mesh_(faces.surface()) {}

  /// Of a path from its source to a point, at least two points.
  [[nodiscard]] LiftedLength<Real> measure(std::span<const Point> path) {
    if (!place(path)) return {unreachable<Real>, 0, unreachable<Real>, false};
    LiftedLength<Real> found = sum_up();
    relax(found);
    const Node &last = nodes_.back(), &before = nodes_[std::ssize(nodes_) - 2];
    const Vec3<Real> from = before.place + before.step * before.derivative;
    const Vec3<Real> way = last.place - from;
    found.direction = stable_unit(Vec3<Real>(way - way.dot(last.normal_in) * last.normal_in));
    return found;
  }

  /// The length of the path measured last on the mesh.
  [[nodiscard]] Real on_mesh() const { return on_mesh_; }

  /// The places of the path measured last, moved towards where it is straight. A way past the other
  /// side of a vertex meets the lines of its edges in reverse: places that would lead back become
  /// one, in their middle.
  [[nodiscard]] std::vector<Vec3<Real>> places() const {
    struct Block {
      Vec3<Real> sum;
      std::ptrdiff_t count;
      [[nodiscard]] Vec3<Real> middle() const { return sum / static_cast<Real>(count); }
    };
    Array<Block> blocks;
    for (std::ptrdiff_t i = 0; i < std::ssize(nodes_); ++i) {
      Block block{moved(nodes_[i]), 1};
      while (blocks.size() > 1 && i + 1 < std::ssize(nodes_)) {
        const Vec3<Real> way = nodes_[i].place - nodes_[i - block.count].place;
        if (!(way.dot(block.middle() - blocks.back().middle()) < 0)) break;
        block.sum += blocks.back().sum;
        block.count += blocks.back().count;
        blocks.pop_back();
      }
      blocks.push_back(block);
    }
    std::vector<Vec3<Real>> out;
    for (const Block& block : blocks) {
      out.insert(out.end(), static_cast<std::size_t>(block.count), start_ + block.middle());
    }
    return out;
  }

 private:
  using Kind = typename Point::Kind;
  // The share of the mesh's mean turn below which that of a path does not tell.
  static constexpr Real least_turn = 0.1;
  // Asin's series to here is as good as 1e-3 of the angle to the fifth.
  static Real angle_of(Real sine) {
    const Real square = sine * sine;
    return sine * (1 + square * (Real(1) / 6 + square * (Real(3) / 40 + square * (Real(5) / 112))));
  }

  struct Node {
    Vec3<Real> flat, place;            // on the mesh and on the surface, as seen from the start
    Vec3<Real> derivative{0, 0, 0};    // where to it may move
    Vec3<Real> normal_in, normal_out;  // as the faces before and after have it
    Index halfedge = -1;               // of an edge that is crossed: in the face before
    Real share = 0;
    Real gradient = 0, diagonal = 0, beside = 0;  // of the length, by the steps; with the next
    Real curvature = 0;                           // of the face after
    Real step = 0;
  };

  // Beyond the end of its edge by no more than the surface's curve there is worth.
  [[nodiscard]] Vec3<Real> moved(const Node& node) const {
    constexpr Real beyond = 0.25;
    if (node.halfedge < 0) return node.place;
    const Real share = std::clamp(node.share + node.step, -beyond, 1 + beyond);
    return faces_.on_edge(node.halfedge, share, start_).place;
  }

  // --- onto the smooth surface -------------------------------------------------------------------

  // Whether each piece lies in a face.
  bool place(std::span<const Point> path) {
    nodes_.assign(path.size(), {});
    on_mesh_ = 0;
    const Index first_element = path[0].element[0];
    start_ = mesh_.position(path[0].kind == Kind::face ? mesh_.origin(3 * first_element)
                                                       : first_element);
    Index before = -1;
    for (std::ptrdiff_t i = 0; i + 1 < std::ssize(nodes_); ++i) {
      const Index f = common_face(path[static_cast<std::size_t>(i)],
                                  path[static_cast<std::size_t>(i) + 1], before);
      if (f < 0) return false;
      if (i == 0) put(nodes_[0], path[0], f);
      nodes_[i].normal_out = normal_in(nodes_[i], path[static_cast<std::size_t>(i)], f, before);
      nodes_[i].curvature = faces_.curvature(f);
      put(nodes_[i + 1], path[static_cast<std::size_t>(i) + 1], f);
      on_mesh_ += (nodes_[i + 1].flat - nodes_[i].flat).norm();
      before = f;
    }
    for (std::ptrdiff_t i = 1; i + 1 < std::ssize(nodes_); ++i) {
      const Point& p = path[static_cast<std::size_t>(i)];
      if (p.kind != Kind::vertex || !faces_.fans().is_smooth(p.element[0])) continue;
      // A vertex may move across the path by about as much as the path is long beside it.
      Node& node = nodes_[i];
      const Vec3<Real> way = nodes_[i + 1].place - nodes_[i - 1].place;
      node.derivative = cross(node.normal_in, way);
    }
    Node& first = nodes_[0];
    first.derivative = nodes_.back().derivative = Vec3<Real>::Zero();
    first.normal_in = first.normal_out;
    return true;
  }

  // Where a vertex is, as seen from the start: exact where they are near, as sums of coordinates
  // are not on a mesh that is far from the origin.
  [[nodiscard]] Vec3<Real> at(Index vertex) const { return mesh_.position(vertex) - start_; }

  // A node at a point, seen from a face.
  void put(Node& node, const Point& p, Index f) {
    if (p.kind == Kind::vertex) {
      node.place = node.flat = at(p.element[0]);
      node.normal_in = faces_.normal(corner(f, p.element[0]));
    } else if (p.kind == Kind::edge) {
      node.halfedge = edge(f, p);
      node.share = p.weights[mesh_.origin(node.halfedge) == p.element[0] ? 1 : 0];
      const auto [place, derivative] = faces_.on_edge(node.halfedge, node.share, start_);
      node.place = place;
      node.flat = (1 - node.share) * at(mesh_.origin(node.halfedge)) +
                  node.share * at(mesh_.tip(node.halfedge));
      node.derivative = derivative;
      node.normal_in = faces_.normal_on_edge(node.halfedge, node.share, derivative);
    } else {
      node.place = faces_.in_face(f, p.weights, start_);
      node.flat = p.weights[0] * at(mesh_.origin(3 * f)) + p.weights[1] * at(mesh_.tip(3 * f)) +
                  p.weights[2] * at(mesh_.apex(3 * f));
      node.normal_in = faces_.normal_in_face(f, p.weights);
    }
  }

  // The normal of a node that was put, as another face has it.
  [[nodiscard]] Vec3<Real> normal_in(const Node& node, const Point& p, Index f,
                                     Index before) const {
    if (f == before || p.kind == Kind::face) return node.normal_in;
    if (p.kind == Kind::vertex) return faces_.normal(corner(f, p.element[0]));
    if (!faces_.fans().is_sharp(node.halfedge)) return node.normal_in;
    const Index h = edge(f, p);
    const bool is_same = mesh_.origin(h) == mesh_.origin(node.halfedge);
    return faces_.normal_on_edge(h, is_same ? node.share : 1 - node.share,
                                 is_same ? node.derivative : Vec3<Real>(-node.derivative));
  }

  [[nodiscard]] Index corner(Index f, Index vertex) const {
    Index h = 3 * f;
    while (mesh_.origin(h) != vertex) ++h;
    return h;
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
    const auto has = [&](Index v) {
      return mesh_.origin(3 * f) == v || mesh_.tip(3 * f) == v || mesh_.apex(3 * f) == v;
    };
    return has(p.element[0]) && (p.kind != Kind::edge || has(p.element[1]));
  }

  // --- how long ----------------------------------------------------------------------------------

  // Lengths of the arcs between the nodes, by the angles between chords and tangents, with the
  // derivatives of their sum.
  LiftedLength<Real> sum_up() {
    LiftedLength<Real> found;
    Real uneven = 0, even = 0;
    for (std::ptrdiff_t i = 0; i + 1 < std::ssize(nodes_); ++i) {
      Node &a = nodes_[i], &b = nodes_[i + 1];
      const Vec3<Real> way = b.place - a.place;
      const Real chord = way.norm();
      if (!(chord > 0)) continue;
      const Vec3<Real> unit = way / chord;
      const Real sine0 = unit.dot(a.normal_out), sine1 = unit.dot(b.normal_in);
      const Real rise = angle_of(sine0), fall = angle_of(sine1);
      // The cubic with these slopes; for a circle's arc, half, also the next order.
      const Real half = (fall - rise) / 2;
      const Real bow = (2 * rise * rise + 2 * fall * fall - rise * fall) / 30;
      const Real arc = chord * (1 + bow + half * half * half * half * (Real(7) / 360));
      found.length += arc;
      uneven += chord * (rise + fall) * (rise + fall);
      even += chord * (fall - rise) * (fall - rise);

      // The tangents at both ends, and how far a step goes along and across them.
      const Real cosine0 = std::sqrt(std::max(Real(0), 1 - sine0 * sine0));
      const Real cosine1 = std::sqrt(std::max(Real(0), 1 - sine1 * sine1));
      if (!(cosine0 > 0) || !(cosine1 > 0)) continue;
      a.gradient -= unit.dot(a.derivative) / cosine0;
      b.gradient += unit.dot(b.derivative) / cosine1;
      const Real across0 = cross(a.normal_out, unit).dot(a.derivative) / cosine0;
      const Real across1 = cross(b.normal_in, unit).dot(b.derivative) / cosine1;
      // The second variation: the integral of x'^2 - K x^2 over the arc, for x linear.
      const Real stretch = 1 / arc, bend = a.curvature * arc / 6;
      a.diagonal += across0 * across0 * (stretch - 2 * bend);
      b.diagonal += across1 * across1 * (stretch - 2 * bend);
      a.beside = -across0 * across1 * (stretch + bend);
    }
    // Where the path hardly turns, what the whole mesh does is the measure.
    even += least_turn * faces_.mean_turn() * found.length;
    found.roughness = even > 0 ? uneven / even : Real(uneven > 0);
    return found;
  }

  // One Newton step of all nodes but the first and last, by elimination.
  void relax(LiftedLength<Real>& found) {
    // Directions that turn by more than about 0.14 are beyond one step.
    constexpr Real least_pivot = 1e-3, most_gain = 0.01;
    Real beside = 0;  // of the node before, over its pivot
    const std::ptrdiff_t last = std::ssize(nodes_) - 1;
    for (std::ptrdiff_t i = 1; i < last; ++i) {
      Node& node = nodes_[i];
      if (node.derivative.isZero(0)) {
        beside = 0;
        continue;
      }
      const Node& before = nodes_[i - 1];
      const Real pivot = node.diagonal - beside * before.beside;
      found.is_least &= pivot > least_pivot * node.diagonal;
      if (!found.is_least) break;
      node.gradient -= beside * before.gradient;
      found.gain += node.gradient * node.gradient / (2 * pivot);
      node.diagonal = pivot;
      beside = node.beside / pivot;
    }
    found.is_least &= found.gain <= most_gain * found.length;
    if (!found.is_least) return;
    // No path is shorter than the straight line through space.
    const Vec3<Real> straight = nodes_[last].place - nodes_[0].place;
    found.gain = std::min(found.gain, found.length - straight.norm());
    for (std::ptrdiff_t i = last - 1; i > 0; --i) {
      Node& node = nodes_[i];
      if (node.derivative.isZero(0)) continue;
      node.step = -(node.gradient + node.beside * nodes_[i + 1].step) / node.diagonal;
    }
  }

  const CurvedFaces<Real>& faces_;
  const Mesh& mesh_;
  Array<Node> nodes_;
  Vec3<Real> start_{0, 0, 0};  // a vertex by the path's source
  Real on_mesh_ = 0;
};

}  // namespace gelight::detail
