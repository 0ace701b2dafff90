#pragma once

#include <cmath>
#include <concepts>
#include <utility>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/repair/mesh_repairs.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::detail {

/// `repair` of a copy.
template <std::floating_point T>
auto repaired(Mesh<T> mesh, const RepairOptions& options, const CancelHook& cancelled)
    -> Repaired<T> {
  const double weld = options.weld_distance.value_or(0);
  require(weld >= 0 && std::isfinite(weld), "the weld distance is ", weld);
  require(options.flat >= 0 && std::isfinite(options.flat), "the flatness is ", options.flat);
  return MeshRepairs(std::move(mesh)).run(options, cancelled);
}

}  // namespace gelight::detail

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template Repaired<float> detail::repaired(Mesh<float>, const RepairOptions&, const CancelHook&);
template Repaired<double> detail::repaired(Mesh<double>, const RepairOptions&, const CancelHook&);
}  // namespace gelight
#endif
