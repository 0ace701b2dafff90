#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/pose.hpp"
#include "gelight/image/raster/draw.hpp"
#include "gelight/image/raster/faces.hpp"
#include "gelight/image/raster/held_faces.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/targets.hpp"
#include "gelight/image/raster/triangle.hpp"

namespace gelight::detail {

inline void require_vertex(Index face, Index vertex, Index vertices) {
  require(vertex >= 0 && vertex < vertices, "face ", face, " has vertex ", vertex,
          ", the mesh has ", vertices, " vertices");
}
/// A vertex by its position in the mesh and in the camera's frame.
inline void require_in_range(const Vec3<double>& own, const Vec3<double>& seen, Index vertex) {
  bool is_finite = true, is_near = true;
  for (Index i = 0; i < 3; ++i) {
    is_finite &= std::isfinite(own[i]);
    is_near &= std::abs(seen[i]) <= most_drawn;
  }
  const auto require_all = [&](bool holds, const Vec3<double>& at, const auto&... what) {
    require(holds, "vertex ", vertex, " at (", at.x(), ", ", at.y(), ", ", at.z(), ") ", what...);
  };
  require_all(is_finite, own, "is not finite");
  require_all(is_near, seen, "is farther off than ", most_drawn);
}

/// Draws what the target needs of a face, or of the part of it that has a place on the plane.
template <class Target>
void draw_face(const Target& target, const ImagePlane& plane, Index width, Index height, Index face,
               const std::array<ImagePoint, 3>& corners,
               const std::array<Vec3<double>, 3>& positions) {
  if (corners[0].inverse_z > 0 && corners[1].inverse_z > 0 && corners[2].inverse_z > 0) {
    if (target.needs(corners)) {
      draw_exactly(target, width, height, face, corners[0], corners[1], corners[2]);
    }
    return;
  }
  if (plane.misses_image(corners)) return;
  const auto polygon = plane.cut(positions, corners);
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const auto &a = polygon.data()[0], &b = polygon.data()[k - 1], &c = polygon.data()[k];
    const ImageTriangle::Shares shares{a.shares, b.shares, c.shares};
    const std::array seen{a.seen, b.seen, c.seen};
    if (target.needs(seen)) {
      draw_exactly(target, width, height, face, a.seen, b.seen, c.seen, &shares);
    }
  }
}

template <TriangleMesh M>
[[nodiscard]] Vec3<double> vertex_position(const M& mesh, Index v) {
  const auto& p = MeshTraits<M>::position(mesh, v);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/// A moved mesh, as it is seen.
template <TriangleMesh M>
class MeshImage {
 public:
  /// The points of all vertices are kept in `points`; null: they are projected face by face.
  MeshImage(const M& mesh, const Pose& pose, const ImagePlane& plane, Index width, Index height,
            ImagePoint* points)
      : mesh_(mesh),
        pose_(pose),
        plane_(plane),
        width_(width),
        height_(height),
        vertices_(static_cast<Index>(Traits::vertex_count(mesh))),
        faces_(static_cast<Index>(Traits::face_count(mesh))),
        points_(points) {
    PositionBatch batch;
    std::array<ImagePoint, PositionBatch::size> own;
    for (Index v = 0; v < vertices_;) {
      ImagePoint* const out = points != nullptr ? points + v : own.data();
      const Index end = std::min(vertices_, v + Index{PositionBatch::size});
      batch.count = 0;
      while (v < end) batch.add(vertex_position(mesh_, v++));
      all_are_usual_ &= plane.project(out, batch, pose_);
    }
  }

  /// Throws for all that may be wrong with the mesh.
  template <class T>
  void check() const {
    const auto end = static_cast<std::uint32_t>(vertices_);
    const auto is_there = [&](Index v) { return static_cast<std::uint32_t>(v) < end; };
    for (Index f = 0; f < faces_; ++f) {
      const Face face = Traits::face(mesh_, f);
      if (is_there(face[0]) && is_there(face[1]) && is_there(face[2])) continue;
      for (const Index v : face) require_vertex(f, v, vertices_);
    }
    if (all_are_usual_) return;
    each_batch(nullptr, [&](const FaceBatch& batch, bool) {
      for (std::size_t i = 0; i < batch.count; ++i) {
        const auto is_fine = [&](std::size_t k) {
          const ImagePoint& p = batch.points[batch.faces[i].corners[k]];
          return p.inverse_z > 0 && is_drawn<T>(p.z);
        };
        if (!(is_fine(0) && is_fine(1) && is_fine(2))) draw_cut(NoTarget<T>{}, batch, i, true);
      }
    });
  }

  /// Null: no faces are held back.
  template <class Target>
  void draw(const Target& target, HeldFaces* held) const {
    if (held != nullptr && !held->begin(faces_, width_, height_)) held = nullptr;
    draw(target, nullptr, held);
    if (held == nullptr) return;
    held->drop_hidden(target, width_, height_);
    draw(target, held, nullptr);
  }

 private:
  using Traits = MeshTraits<M>;
  using Face = std::array<Index, 3>;

  template <class Target>
  void draw(const Target& target, const HeldFaces* some, HeldFaces* held) const {
    FaceMeasures measures;
    WaitingFaces waiting(!target.order_is_free());
    each_batch(some, [&](const FaceBatch& batch, bool is_last) {
      measures.find(batch, width_, height_, held != nullptr);
      for (std::size_t i = 0;; ++i) {
        i = draw_batch(target, width_, height_, batch, measures, i, held, waiting, is_last);
        if (i == batch.count) break;
        draw_cut(target, batch, i, false);
      }
    });
  }

  /// Calls `work(batch, is_last)` with some faces after the other, of those given or of all, and
  /// whether it is the last with these points.
  template <class Work>
  void each_batch(const HeldFaces* some, const Work& work) const {
    FaceBatch batch;
    PositionBatch positions;
    std::array<ImagePoint, PositionBatch::size> own;
    batch.points = points_ != nullptr ? points_ : own.data();
    batch.are_usual = all_are_usual_;
    const Index count = some != nullptr ? some->count() : faces_;
    for (Index first = 0; first < count; first += Index{FaceBatch::size}) {
      const auto size = static_cast<std::size_t>(std::min(count - first, Index{FaceBatch::size}));
      batch.count = size;
      for (std::size_t i = 0; i < size; ++i) {
        const Index n = first + static_cast<Index>(i), f = some != nullptr ? some->face(n) : n;
        const Face face = Traits::face(mesh_, f);
        batch.faces[i] = {{face[0], face[1], face[2]}, f};
        if (points_ == nullptr) continue;
        for (const Index v : face) prefetch(points_ + v, 1);
      }
      if (points_ == nullptr) batch.are_usual = project_corners(own.data(), positions, batch);
      work(batch, points_ == nullptr || count - first <= Index{FaceBatch::size});
    }
  }

  /// Projects the corners of the faces one by one.
  [[nodiscard]] bool project_corners(ImagePoint* out, PositionBatch& positions,
                                     FaceBatch& batch) const {
    positions.count = 0;
    for (std::size_t i = 0; i < batch.count; ++i) {
      for (Index& v : batch.faces[i].corners) {
        const auto at = static_cast<Index>(positions.count);
        positions.add(vertex_position(mesh_, v));
        v = at;
      }
    }
    return plane_.project(out, positions, pose_);
  }

  /// Draws a face of a batch, or the part of it that has a place on the plane.
  template <class Target>
  void draw_cut(const Target& target, const FaceBatch& batch, std::size_t i,
                bool is_checked) const {
    const auto& [a, b, c] = batch.faces[i].corners;
    const std::array seen{batch.points[a], batch.points[b], batch.points[c]};
    const Index f = batch.faces[i].number;
    std::array<Vec3<double>, 3> positions;
    if (!(seen[0].inverse_z > 0 && seen[1].inverse_z > 0 && seen[2].inverse_z > 0)) {
      const Face face = Traits::face(mesh_, f);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3<double> own = vertex_position(mesh_, face[k]);
        positions[k] = pose_(own);
        if (is_checked) require_in_range(own, positions[k], face[k]);
      }
    }
    draw_face(target, plane_, width_, height_, f, seen, positions);
  }

  const M& mesh_;
  const Pose& pose_;
  const ImagePlane& plane_;
  Index width_, height_;
  Index vertices_, faces_;
  const ImagePoint* points_;
  bool all_are_usual_ = true;  // of the points of vertices
};

}  // namespace gelight::detail
