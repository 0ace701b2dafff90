#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <limits>
#include <string>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

/// What is lost of a mesh where its points are rounded, in its unit.
struct Rounding {
  double farthest = 0;  ///< of the coordinates
  double edge = 0;      ///< their mean length
  double error = 0;     ///< of a coordinate, at most

  /// Whether more than this share of an edge is lost.
  [[nodiscard]] bool exceeds(double share) const { return !(error <= share * edge); }
};

/// For points that are rounded to numbers of type T.
template <std::floating_point T>
[[nodiscard]] Rounding rounding_of(const gelight::Mesh<double>& mesh) {
  Rounding rounding;
  for (const auto& p : mesh.positions) {
    for (const double c : p) rounding.farthest = std::max(rounding.farthest, std::abs(c));
  }
  double length = 0;
  for (const auto& [a, b, c] : mesh.faces) {
    const auto at = [&](gelight::Index v) {
      return gelight::Vec3<double>(mesh.position(v).data());
    };
    length += (at(b) - at(a)).norm() + (at(c) - at(b)).norm() + (at(a) - at(c)).norm();
  }
  rounding.edge = length / static_cast<double>(3 * mesh.faces.size());
  rounding.error = rounding.farthest * double{std::numeric_limits<T>::epsilon()} / 2;
  return rounding;
}

/// Throws InvalidInput where a mesh lies so far from the origin, for the length of its edges, that
/// numbers of type T bend it.
template <std::floating_point T>
void require_precision(const gelight::Mesh<double>& mesh, const std::string& name) {
  using gelight::detail::two_digits;
  const Rounding rounding = rounding_of<T>(mesh);
  gelight::detail::require(!rounding.exceeds(1e-4), name, " lies ", two_digits(rounding.farthest),
                           " from the origin, where ", sizeof(T) == 4 ? "single" : "double",
                           " precision rounds its points by ", two_digits(rounding.error),
                           ", too much for edges of ", two_digits(rounding.edge),
                           "; move it to the origin");
}

/// The mesh of a file that OpenMesh reads (STL, OBJ, PLY, OFF). Throws InvalidInput if there is
/// none in it, or one that OpenMesh would mend: points and faces that it leaves out or tears off;
/// and where there is no area.
/// Points of STL are single, others double: they must lie near enough to the origin for that.
/// Polygons become fans of triangles from their first corner, which overlap where it does not see
/// all of a concave one.
[[nodiscard]] gelight::Mesh<double> mesh_of_file(const std::filesystem::path& path);
