#pragma once

#include <cmath>
#include <concepts>
#include <iterator>
#include <ostream>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair/mesh_checks.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {
namespace detail {

/// `check` of a copy.
template <std::floating_point T>
auto checked_mesh(const Mesh<T>& mesh, const CheckOptions& options, const CancelHook& cancelled)
    -> MeshReport {
  require(options.listed >= 0, "the number of indices to list is ", options.listed);
  require(options.flat >= 0 && std::isfinite(options.flat), "the flatness is ", options.flat);
  return MeshChecks(mesh, options).run(cancelled);
}

}  // namespace detail

GELIGHT_INLINE std::ostream& operator<<(std::ostream& out, const MeshReport& report) {
  const auto line = [&](const Finding& finding, const char* what, const char* then) {
    if (finding.count == 0) return;
    out << '\n' << finding.count << ' ' << what << ": ";
    for (std::size_t i = 0; i < finding.first.size(); ++i) {
      out << (i > 0 ? ", " : "") << finding.first[i];
    }
    out << (std::ssize(finding.first) < finding.count ? ", ..." : "") << " (" << then << ')';
  };
  out << report.vertices << " vertices, " << report.faces << " faces, " << report.components
      << " components";
  line(report.not_finite, "vertices that are not finite", "refused");
  line(report.too_far, "vertices farther out than 1e75", "refused");
  if (report.is_too_small) out << "\nno edge is as long as 1e-75 (refused)";
  line(report.out_of_range, "faces with an index out of range", "refused");
  line(report.repeated_vertices, "faces with a vertex twice", "refused");
  line(report.repeated_faces, "faces with the vertices of an earlier one", "refused");
  line(report.too_long, "faces with an edge too long for the coordinates' type", "refused");
  line(report.nonmanifold_edges, "edges of more than two faces, at vertices",
       "refused for vectors");
  line(report.misoriented_edges, "edges between faces oriented against each other, at vertices",
       "refused for vectors");
  line(report.degenerate_faces, "faces without area", "taken");
  line(report.zero_edges, "edges without length, at vertices", "taken");
  line(report.duplicate_vertices, "vertices at the place of an earlier one",
       "taken; no path crosses such a seam");
  line(report.unused_vertices, "vertices in no face", "taken; infinitely far");
  line(report.nonmanifold_vertices, "vertices of several fans", "taken; paths pass through");
  line(report.border_edges, "border edges, at vertices", "taken");
  return out;
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template MeshReport detail::checked_mesh(const Mesh<float>&, const CheckOptions&,
                                         const CancelHook&);
template MeshReport detail::checked_mesh(const Mesh<double>&, const CheckOptions&,
                                         const CancelHook&);
}  // namespace gelight
#endif
