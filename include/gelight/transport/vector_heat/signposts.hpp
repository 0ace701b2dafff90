#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/tangent.hpp"

namespace gelight::detail {

/// Directions of the half-edges of an intrinsic triangulation in the tangent planes of the surface
/// that it triangulates.
template <std::floating_point Real>
struct Signposts {
  IntrinsicTriangulation<Real> mesh;
  Array<Real> angle;  // of each half-edge, at its origin
  Array<Real> far;    // of the edge before each half-edge, at the same vertex

  /// Of the surface's own edges, with the lengths and angles given.
  Signposts(IntrinsicTriangulation<Real> own, const TangentFrames<Real>& frames)
      : mesh(std::move(own)) {
    angle.reserve(mesh.origins.size());
    far.reserve(mesh.origins.size());
    for (Index h = 0; h < static_cast<Index>(mesh.origins.size()); ++h) {
      angle.push_back(frames.angle(h));
      far.push_back(frames.angle_back(previous(h)));
    }
  }

  static Index next(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static Index previous(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }

  /// Direction of the way back along h in the tangent plane of its tip.
  [[nodiscard]] Real angle_back(Index h) const { return far[next(h)]; }

  /// The angle between h and the edge before it in their face.
  [[nodiscard]] Real corner(Index h) const {
    const PlanarFace face =
        laid_out({mesh.lengths[h], mesh.lengths[next(h)], mesh.lengths[previous(h)]});
    return std::atan2(face.y2, face.x2);
  }

  /// Flips an edge, and finds the new edge's directions by the angles to its neighbours, scaled as
  /// those round each vertex are (Sharp, Soliman, Crane 2019, doi:10.1145/3306346.3322979).
  void flip_edge(Index h, Real length) {
    const Index t = mesh.twins[h], left = h - h % 3, right = t - t % 3;
    // As `flip` moves the four sides, and with them the corners at their origins.
    const std::array<Index, 4> from{previous(h), next(t), previous(t), next(h)};
    // The corners beside the edge become one; angles of the next corner may be a full turn off.
    const auto width = [&](Index g) { return far[g] - angle[g]; };
    const std::array<Real, 4> widths{width(from[0]), width(from[1]) + width(h), width(from[2]),
                                     width(from[3]) + width(t)};
    const std::array<Real, 4> begins{angle[from[0]], angle[from[1]], angle[from[2]],
                                     angle[from[3]]};
    flip(mesh, h, length);
    const std::array<Index, 4> to{left + 1, left + 2, right + 1, right + 2};
    for (std::size_t k = 0; k < 4; ++k) {
      angle[to[k]] = begins[k];
      far[to[k]] = begins[k] + widths[k];
    }
    // The new edge parts the corners across the old one.
    for (const auto& [side, edge] : {std::pair(left + 1, right), std::pair(right + 1, left)}) {
      const Real before = corner(side), after = corner(edge);
      far[edge] = far[side];
      far[side] = angle[edge] = angle[side] + (far[edge] - angle[side]) * before / (before + after);
    }
  }
};

}  // namespace gelight::detail
