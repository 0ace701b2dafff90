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
#include "gelight/geodesic/exact/lane.hpp"
#include "gelight/geodesic/smooth/curved_faces.hpp"
#include "gelight/geodesic/smooth/path_marks.hpp"
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

  explicit LiftedPath(const CurvedFaces<Real>& faces)
      : faces_(faces), mesh_(faces.surface()), given_(mesh_) {}

  /// Of a path from its source to a point, at least two points.
  [[nodiscard]] LiftedLength<Real> measure(std::span<const Point> path) {
    if (!given_.assign(path)) return nowhere();
    return measure(given_);
  }
  /// Of at least two marks.
  [[nodiscard]] LiftedLength<Real> measure(const PathMarks<Real>& path) {
    if (!place(path)) return nowhere();
    LiftedLength<Real> found = sum_up();
    relax(found);
    found.direction = arrival();
    return found;
  }

  /// The length of the path measured last on the mesh.
  [[nodiscard]] Real on_mesh() const { return on_mesh_; }

  /// The places of the path measured last, moved towards where it is straight. A way past the other
  /// side of a vertex meets the lines of its edges in reverse: places that would lead back become
  /// one, in their middle.
  [[nodiscard]] std::vector<Vec3<Real>> places(const PathMarks<Real>& path) {
    struct Block {
      Vec3<Real> sum;
      std::ptrdiff_t count;
      [[nodiscard]] Vec3<Real> middle() const { return sum / static_cast<Real>(count); }
    };
    find_steps();
    Array<Block> blocks;
    for (std::ptrdiff_t i = 0; i < count_; ++i) {
      Block block{moved(path[i], i), 1};
      while (blocks.size() > 1 && i + 1 < count_) {
        const Vec3<Real> way = place_.at(i) - place_.at(i - block.count);
        if (!(dot(way, block.middle() - blocks.back().middle()) < 0)) break;
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
  [[nodiscard]] std::vector<Vec3<Real>> places() { return places(given_); }

 private:
  using Kind = typename Point::Kind;
  using Marks = PathMarks<Real>;
  using Mark = PathMark<Real>;
  using Curve = typename CurvedFaces<Real>::Curve;
  // The share of the mesh's mean turn below which that of a path does not tell.
  static constexpr Real least_turn = 0.1;
  // What squares and lengths that are zero are taken for, so that nothing over them is nothing; and
  // the least square of a cosine.
  static constexpr Real nothing = 1e-300, least_cosine = 1e-12;

  static LiftedLength<Real> nowhere() {
    return {unreachable<Real>, 0, unreachable<Real>, false, {0, 0, 0}};
  }

  // Three numbers of each node, in columns; and of four nodes at once.
  struct LaneVector {
    Lane x, y, z;

    friend Lane dot(const LaneVector& a, const LaneVector& b) {
      return a.x * b.x + a.y * b.y + a.z * b.z;
    }
    friend LaneVector operator+(const LaneVector& a, const LaneVector& b) {
      return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend LaneVector operator-(const LaneVector& a, const LaneVector& b) {
      return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend LaneVector operator*(Lane s, const LaneVector& a) { return {s * a.x, s * a.y, s * a.z}; }
    friend LaneVector cross(const LaneVector& a, const LaneVector& b) {
      return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
  };
  class Columns {
   public:
    void resize(std::ptrdiff_t rows) {
      rows_ = rows;
      if (std::ssize(all_) < 3 * rows) all_.resize(static_cast<std::size_t>(3 * rows));
    }
    [[nodiscard]] Vec3<Real> at(std::ptrdiff_t i) const {
      return {all_[i], all_[rows_ + i], all_[2 * rows_ + i]};
    }
    void set(std::ptrdiff_t i, const Vec3<Real>& v) {
      for (std::ptrdiff_t k = 0; k < 3; ++k) all_[k * rows_ + i] = v[k];
    }
    [[nodiscard]] LaneVector load(std::ptrdiff_t i) const {
      const Real* x = all_.data() + i;
      return {Lane::load(x), Lane::load(x + rows_), Lane::load(x + 2 * rows_)};
    }
    void store(std::ptrdiff_t i, const LaneVector& v) {
      Real* x = all_.data() + i;
      v.x.store(x);
      v.y.store(x + rows_);
      v.z.store(x + 2 * rows_);
    }

   private:
    Array<Real> all_;
    std::ptrdiff_t rows_ = 0;
  };

  // Beyond the end of its edge by no more than the surface's curve there is worth.
  [[nodiscard]] Vec3<Real> moved(const Mark& mark, std::ptrdiff_t i) const {
    constexpr Real beyond = 0.25;
    if (!mark.is_crossing()) return place_.at(i);
    const bool is_along = mesh_.origin(mark.halfedge) == faces_.curve(mark.halfedge).from;
    // Steps lead along the edge's curve from where that begins.
    const Real step = is_along ? steps_[i] : -steps_[i];
    const Real share = std::clamp(mark.share + step, -beyond, 1 + beyond);
    return faces_.on_edge(mark.halfedge, share, start_).place;
  }

  // --- onto the smooth surface -------------------------------------------------------------------

  // Whether each piece lies in a face.
  bool place(const Marks& path) {
    make_room(path.size());
    const Point first = path.point(path[0]);
    start_ = mesh_.position(first.kind == Kind::face ? mesh_.origin(3 * first.element[0])
                                                     : first.element[0]);
    for (std::ptrdiff_t i = 0; i + 1 < count_; ++i) {
      const Index f = path.face_after(i);
      if (f < 0) return false;
      face_[i] = f;
      curvature_[i] = faces_.curvature(f);
    }
    others_.clear();
    for (std::ptrdiff_t i = 0; i < count_; i += Lane::size) place_four(path, i);
    for (const std::ptrdiff_t i : others_) place_other(path[i], path.point(path[i]), i);
    for (const std::ptrdiff_t i : others_) let_move(path[i], i);
    // No piece leads from the last node to those that fill its lane.
    for (std::ptrdiff_t i = count_; i < count_ + Lane::size; ++i) {
      for (Columns* columns : {&flat_, &place_, &derivative_, &normal_in_, &normal_out_}) {
        columns->set(i, columns->at(count_ - 1));
      }
      curvature_[i - 1] = 0;
    }
    return true;
  }

  void make_room(std::ptrdiff_t count) {
    count_ = count;
    const std::ptrdiff_t rows = count + 2 * Lane::size;
    for (Columns* columns : {&flat_, &place_, &derivative_, &normal_in_, &normal_out_}) {
      columns->resize(rows);
    }
    if (std::ssize(face_) >= rows) return;
    const auto size = static_cast<std::size_t>(rows);
    face_.resize(size);
    for (Array<Real>* column : {&curvature_, &gradient_out_, &gradient_in_, &diagonal_out_,
                                &diagonal_in_, &beside_, &steps_, &ratio_}) {
      column->resize(size);
    }
  }

  // Four nodes, as points of curves; of others the place alone.
  void place_four(const Marks& path, std::ptrdiff_t i) {
    std::array<const Curve*, Lane::size> curves;
    std::array<Real, Lane::size> shares;
    for (std::size_t lane = 0; lane < curves.size(); ++lane) {
      const std::ptrdiff_t node = i + static_cast<std::ptrdiff_t>(lane);
      const Mark& mark = path[std::min(node, count_ - 1)];
      const Index h = std::max(mark.halfedge, 0);
      const Curve& curve = faces_.curve(h);
      curves[lane] = &curve;
      shares[lane] = mesh_.origin(h) == curve.from ? mark.share : 1 - mark.share;
      if ((curve.from_fan < 0 || !mark.is_crossing()) && node < count_) others_.push_back(node);
    }
    const auto four = [&](const auto& vector_of) {
      const Vec3<Real>&a = vector_of(*curves[0]), &b = vector_of(*curves[1]),
            &c = vector_of(*curves[2]), &d = vector_of(*curves[3]);
      const auto row = [&](int k) { return Lane(a[k], b[k], c[k], d[k]); };
      return LaneVector{row(0), row(1), row(2)};
    };
    const auto from = four([&](const Curve& c) -> auto& { return mesh_.position(c.from); });
    const auto to = four([&](const Curve& c) -> auto& { return mesh_.position(c.to); });
    const auto out = four([&](const Curve& c) -> auto& { return c.leaving; });
    const auto in = four([&](const Curve& c) -> auto& { return c.arriving; });
    const auto normal0 =
        four([&](const Curve& c) -> auto& { return faces_.fan_normal(std::max(c.from_fan, 0)); });
    const auto normal1 =
        four([&](const Curve& c) -> auto& { return faces_.fan_normal(std::max(c.to_fan, 0)); });
    const Lane s(shares[0], shares[1], shares[2], shares[3]), r = Lane(1) - s;
    const LaneVector start{start_.x(), start_.y(), start_.z()};
    const LaneVector begin = from - start, way = to - from;
    flat_.store(i, begin + s * way);
    place_.store(i, begin + (s * s * (Lane(3) - Lane(2) * s)) * way + (s * r) * (r * out - s * in));
    const LaneVector derivative =
        (Lane(6) * s * r) * way + (r * (r - Lane(2) * s)) * out + (s * (s - Lane(2) * r)) * in;
    derivative_.store(i, derivative);
    const LaneVector mean = r * normal0 + s * normal1;
    const Lane square = max(dot(derivative, derivative), nothing);
    const LaneVector across = mean - (dot(mean, derivative) / square) * derivative;
    const LaneVector normal = (Lane(1) / sqrt(max(dot(across, across), nothing))) * across;
    normal_in_.store(i, normal);
    normal_out_.store(i, normal);
  }

  // A node at a crease, at a vertex or inside of a face.
  void place_other(const Mark& mark, const Point& p, std::ptrdiff_t i) {
    const Index before = face_[std::max(i - 1, std::ptrdiff_t{0})];
    const Index after = face_[std::min(i, count_ - 2)];
    if (mark.is_crossing()) {
      const auto as_seen = [&](Index h) {
        const bool is_same = mesh_.origin(h) == mesh_.origin(mark.halfedge);
        const Real share = is_same ? mark.share : 1 - mark.share;
        return faces_.normal_on_edge(h, share, faces_.on_edge(h, share, start_).derivative);
      };
      normal_in_.set(i, as_seen(mark.other));
      normal_out_.set(i, as_seen(mark.halfedge));
      return;
    }
    derivative_.set(i, {0, 0, 0});
    if (p.kind == Kind::vertex) {
      const Vec3<Real> place = at(p.element[0]);
      flat_.set(i, place);
      place_.set(i, place);
      normal_in_.set(i, faces_.normal(corner(before, p.element[0])));
      normal_out_.set(i, faces_.normal(corner(after, p.element[0])));
      return;
    }
    // The path's begin or end: in one face.
    Vec3<Real> normal;
    if (p.kind == Kind::face) {
      const Index f = p.element[0];
      flat_.set(i, p.weights[0] * at(mesh_.origin(3 * f)) + p.weights[1] * at(mesh_.tip(3 * f)) +
                       p.weights[2] * at(mesh_.apex(3 * f)));
      place_.set(i, faces_.in_face(f, p.weights, start_));
      normal = faces_.normal_in_face(f, p.weights);
    } else {
      const Index h = edge(before, p);
      const Real share = p.weights[mesh_.origin(h) == p.element[0] ? 1 : 0];
      const auto [place, derivative] = faces_.on_edge(h, share, start_);
      flat_.set(i, (1 - share) * at(mesh_.origin(h)) + share * at(mesh_.tip(h)));
      place_.set(i, place);
      normal = faces_.normal_on_edge(h, share, derivative);
    }
    normal_in_.set(i, normal);
    normal_out_.set(i, normal);
  }

  // A vertex may move across the path by about as much as the path is long beside it.
  void let_move(const Mark& mark, std::ptrdiff_t i) {
    if (mark.halfedge != Mark::vertex || i == 0 || i + 1 == count_) return;
    if (!faces_.fans().is_smooth(mark.other)) return;
    derivative_.set(i, cross<Real>(normal_in_.at(i), place_.at(i + 1) - place_.at(i - 1)));
  }

  // Where a vertex is, as seen from the start: exact where they are near, as sums of coordinates
  // are not on a mesh that is far from the origin.
  [[nodiscard]] Vec3<Real> at(Index vertex) const { return mesh_.position(vertex) - start_; }

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

  // --- how long ----------------------------------------------------------------------------------

  // Asin's series to here is as good as 1e-3 of the angle to the fifth.
  static Lane angle_of(Lane sine) {
    const Lane square = sine * sine;
    return sine * (Lane(1) +
                   square * (Lane(1.0 / 6) + square * (Lane(3.0 / 40) + square * Lane(5.0 / 112))));
  }

  struct Sums {
    Lane flat{0}, length{0}, uneven{0}, even{0};
  };
  static Real total(Lane lane) {
    Real parts[Lane::size];
    lane.store(parts);
    return (parts[0] + parts[1]) + (parts[2] + parts[3]);
  }

  // Lengths of the arcs between the nodes, by the angles between chords and tangents, with the
  // derivatives of their sum.
  LiftedLength<Real> sum_up() {
    Sums sums;
    for (std::ptrdiff_t i = 0; i + 1 < count_; i += Lane::size) sum_four(i, sums);
    LiftedLength<Real> found;
    on_mesh_ = total(sums.flat);
    found.length = total(sums.length);
    const Real uneven = total(sums.uneven);
    // Where the path hardly turns, what the whole mesh does is the measure.
    const Real even = total(sums.even) + least_turn * faces_.mean_turn() * found.length;
    found.roughness = even > 0 ? uneven / even : Real(uneven > 0);
    return found;
  }

  // Four pieces.
  void sum_four(std::ptrdiff_t i, Sums& sums) {
    const LaneVector flat = flat_.load(i + 1) - flat_.load(i);
    sums.flat = sums.flat + sqrt(dot(flat, flat));
    const LaneVector way = place_.load(i + 1) - place_.load(i);
    const Lane chord = sqrt(dot(way, way));
    const LaneVector unit = (Lane(1) / max(chord, nothing)) * way;
    const LaneVector normal0 = normal_out_.load(i), normal1 = normal_in_.load(i + 1);
    const Lane sine0 = dot(unit, normal0), sine1 = dot(unit, normal1);
    const Lane rise = angle_of(sine0), fall = angle_of(sine1);
    // The cubic with these slopes; for a circle's arc, half, also the next order.
    const Lane sum = rise + fall, turn = fall - rise, square = turn * turn;
    const Lane bow = (Lane(2) * (rise * rise + fall * fall) - rise * fall) * Lane(1.0 / 30);
    const Lane arc = chord * (Lane(1) + bow + square * square * Lane(7.0 / (360 * 16)));
    sums.length = sums.length + arc;
    sums.uneven = sums.uneven + chord * (sum * sum);
    sums.even = sums.even + chord * square;

    // The tangents at both ends, and how far a step goes along and across them.
    const Lane secant0 = Lane(1) / sqrt(max(Lane(1) - sine0 * sine0, least_cosine));
    const Lane secant1 = Lane(1) / sqrt(max(Lane(1) - sine1 * sine1, least_cosine));
    const LaneVector derivative0 = derivative_.load(i), derivative1 = derivative_.load(i + 1);
    (Lane(0) - dot(unit, derivative0) * secant0).store(&gradient_out_[i]);
    (dot(unit, derivative1) * secant1).store(&gradient_in_[i]);
    const Lane across0 = dot(cross(normal0, unit), derivative0) * secant0;
    const Lane across1 = dot(cross(normal1, unit), derivative1) * secant1;
    // The second variation: the integral of x'^2 - K x^2 over the arc, for x linear.
    const Lane stretch = Lane(1) / max(arc, nothing);
    const Lane bend = Lane::load(&curvature_[i]) * arc * Lane(1.0 / 6);
    const Lane straight = stretch - Lane(2) * bend;
    (across0 * across0 * straight).store(&diagonal_out_[i]);
    (across1 * across1 * straight).store(&diagonal_in_[i]);
    (Lane(0) - across0 * across1 * (stretch + bend)).store(&beside_[i]);
  }

  // One Newton step of all nodes but the first and last, by elimination.
  void relax(LiftedLength<Real>& found) {
    // Directions that turn by more than about 0.14 are beyond one step.
    constexpr Real least_pivot = 1e-3, most_gain = 0.01;
    Real ratio = 0, gradient = 0, doubled = 0;  // of the node before: beside over pivot
    std::fill_n(steps_.begin(), count_, Real(0));
    for (std::ptrdiff_t i = 1; i + 1 < count_; ++i) {
      const Real diagonal = diagonal_in_[i - 1] + diagonal_out_[i];
      if (diagonal == 0) {
        // It cannot move.
        ratio = gradient = ratio_[i] = 0;
        continue;
      }
      const Real pivot = diagonal - ratio * beside_[i - 1];
      found.is_least &= pivot > least_pivot * diagonal;
      if (!found.is_least) break;
      const Real inverse = 1 / pivot;
      gradient = gradient_in_[i - 1] + gradient_out_[i] - ratio * gradient;
      ratio = ratio_[i] = beside_[i] * inverse;
      steps_[i] = -gradient * inverse;
      doubled -= gradient * steps_[i];
    }
    found.gain = doubled / 2;
    found.is_least &= found.gain <= most_gain * found.length;
    if (!found.is_least) std::fill_n(steps_.begin(), count_, Real(0));
    // No path is shorter than the straight line through space.
    const Vec3<Real> straight = place_.at(count_ - 1) - place_.at(0);
    found.gain = std::min(found.gain, found.length - norm(straight));
  }

  // The tangent in which the last piece arrives. The step before it is known: the last takes none.
  [[nodiscard]] Vec3<Real> arrival() const {
    const std::ptrdiff_t last = count_ - 1;
    const Vec3<Real> from = place_.at(last - 1) + steps_[last - 1] * derivative_.at(last - 1);
    const Vec3<Real> way = place_.at(last) - from, normal = normal_in_.at(last);
    return stable_unit(Vec3<Real>(way - dot(way, normal) * normal));
  }

  // Of all nodes, from those that elimination left: the last one's is whole.
  void find_steps() {
    for (std::ptrdiff_t i = count_ - 3; i > 0; --i) {
      if (steps_[i] != 0) steps_[i] -= ratio_[i] * steps_[i + 1];
    }
  }

  const CurvedFaces<Real>& faces_;
  const Mesh& mesh_;
  Marks given_;  // of a path of points
  std::ptrdiff_t count_ = 0;
  Vec3<Real> start_{0, 0, 0};  // a vertex by the path's source
  Real on_mesh_ = 0;
  // Of each node: its place on the mesh and on the surface, as seen from the start, where to it may
  // move, and its normals as the faces before and after have it.
  Columns flat_, place_, derivative_, normal_in_, normal_out_;
  Array<std::ptrdiff_t> others_;  // nodes that are not on a smooth edge
  // Of the piece after each node.
  Array<Index> face_;
  Array<Real> curvature_;
  // The length's derivatives by the steps of a piece's begin (out) and end (in), and of both.
  Array<Real> gradient_out_, gradient_in_, diagonal_out_, diagonal_in_, beside_;
  Array<Real> steps_, ratio_;  // of each node
};

}  // namespace gelight::detail
