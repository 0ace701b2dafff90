#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/detail/mesh_statistics.hpp"

namespace gelight::detail {

/// The methods that DistancePlanner chooses from.
enum class Method { dijkstra, virtual_source, fast_marching, exact };
inline constexpr std::array<Method, 4> all_methods{Method::dijkstra, Method::virtual_source,
                                                   Method::fast_marching, Method::exact};

/// What a method, or a check, costs: nanoseconds a vertex of set-up and of a query at 10,000
/// vertices, the power of the number of vertices (beyond linear) by which a query grows, and bytes
/// a vertex. Times on one core of an AMD EPYC.
struct MethodCost {
  const char* name;
  double setup_ns, query_ns, growth, bytes;

  [[nodiscard]] double seconds(Index vertices, Index queries) const {
    const double query = query_ns * std::pow(vertices / 1e4, growth);
    return 1e-9 * vertices * (setup_ns + queries * query);
  }
};

inline constexpr std::array<MethodCost, 4> method_costs{{{"dijkstra", 100, 45, 0.2, 400},
                                                         {"virtual_source", 110, 160, 0.05, 450},
                                                         {"fast_marching", 160, 95, 0.05, 600},
                                                         {"exact", 160, 1400, 0.5, 600}}};
[[nodiscard]] constexpr const MethodCost& cost_of(Method method) {
  return method_costs[static_cast<std::size_t>(method)];
}
inline constexpr MethodCost certificate_cost{"certificate", 160, 650, 0.1, 1100};
inline constexpr MethodCost paths_cost{"paths", 0, 50, -0.5, 10};

/// What checking one target exactly costs, as a share of an exact query.
inline constexpr double sample_share = 0.1;

/// Errors of the methods as experience has them. (A template only so that it costs nothing to
/// include.)
template <std::floating_point Real>
class MethodErrors {
 public:
  explicit MethodErrors(const MeshStatisticsOf<Real>& mesh) : mesh_(mesh) {}

  /// Against the mesh, from the worst of its vertices, as the meshes of benchmarks/pareto and of
  /// the tests have it.
  [[nodiscard]] RelativeError of(Method method) const {
    switch (method) {
      case Method::dijkstra:
        return {0.12 * mesh_.aspect, 0.8 * mesh_.aspect};
      case Method::virtual_source:
        return of_virtual_sources();
      case Method::fast_marching:
        return of_fast_marching();
      default:
        return {1e-14 * mesh_.aspect, 1e-14 * mesh_.aspect * mesh_.aspect};
    }
  }

  /// What a certificate proves of a method's distances, typically: nothing is lost but time where
  /// it proves less.
  [[nodiscard]] RelativeError provable(Method method) const {
    const double curved = std::min(0.06 * mesh_.curvature * (1 + mesh_.aspect / 30),
                                   0.2 * mesh_.bend * (1 + 0.1 * mesh_.aspect));
    const double mean = 1e-5 * mesh_.aspect + curved + std::min(0.2, mesh_.obtuse * mesh_.obtuse);
    const RelativeError own = of(method);
    return {std::max(mean, own.mean), std::max(20 * mean, own.max)};
  }

 private:
  [[nodiscard]] RelativeError of_virtual_sources() const {
    const bool is_regular = mesh_.aspect < 3 && mesh_.obtuse < 0.02 && mesh_.corner < 0.01;
    if (is_regular && mesh_.is_flat) return {1e-9, 1e-8};
    if (is_regular && mesh_.is_convex) return {0.2 * mesh_.turn * mesh_.turn, 0.1 * mesh_.turn};
    return {0.02, 0.3};
  }

  // On smooth surfaces it goes with the total curvature, a thirtieth of it at the scale of an edge;
  // where most of that is noise, which averages out, with the size of the angle defects; beside
  // corners of the border with how sharp they are.
  [[nodiscard]] RelativeError of_fast_marching() const {
    const double bend = mesh_.bend / (1 + 3.5 * mesh_.bend);
    const double noisy = 0.08 * bend * (0.45 + std::sqrt(mesh_.aspect) / 2);
    const double mean = 9e-6 * mesh_.aspect + 6e-4 * mesh_.obtuse +
                        std::min(noisy, 0.03 * mesh_.curvature) + 0.0026 * mesh_.corner;
    return {std::min(0.02, mean), std::min(0.1, 20 * mean)};
  }

  const MeshStatisticsOf<Real>& mesh_;
};

}  // namespace gelight::detail
