#pragma once

#include <cmath>

#include "gelight/core/types.hpp"

namespace gelight {

/// What a method, or a check, costs on a machine.
struct MethodCost {
  double setup_ns = 0;  ///< Nanoseconds a vertex of set-up.
  double query_ns = 0;  ///< Nanoseconds a vertex of a query on a mesh of 10,000 vertices.
  double growth = 0;    ///< Power of the number of vertices by which that grows.
  double bytes = 0;     ///< A vertex, beyond the mesh.

  /// Of so many queries that share their set-up, in seconds.
  [[nodiscard]] double seconds(Index vertices, Index queries) const {
    const double query = query_ns * std::pow(vertices / 1e4, growth);
    return 1e-9 * vertices * (setup_ns + queries * query);
  }
};

/// What the methods that DistancePlanner chooses from cost, and its checks.
struct PlanCosts {
  MethodCost dijkstra;        ///< DijkstraSolver.
  MethodCost virtual_source;  ///< VirtualSourceSolver.
  MethodCost fast_marching;   ///< FastMarchingSolver.
  MethodCost exact;           ///< ExactSolver.
  MethodCost certificate;     ///< Bounds of an approximate answer.
  MethodCost paths;           ///< Following some back through an approximate answer.
  double sample_share = 0;    ///< Of checking one target exactly, as a share of an exact query.
};

}  // namespace gelight
