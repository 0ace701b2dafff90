#pragma once

#include <cmath>

#include "gelight/core/types.hpp"

namespace gelight {

/// What a method, or a check, costs on a machine: nanoseconds a vertex of set-up and of a query at
/// 10,000 vertices, the power of the number of vertices (beyond linear) by which a query grows, and
/// bytes a vertex beyond the mesh.
struct MethodCost {
  double setup_ns = 0, query_ns = 0, growth = 0, bytes = 0;

  /// Of so many queries that share their set-up, in seconds.
  [[nodiscard]] double seconds(Index vertices, Index queries) const {
    const double query = query_ns * std::pow(vertices / 1e4, growth);
    return 1e-9 * vertices * (setup_ns + queries * query);
  }
};

/// What the methods that DistancePlanner chooses from cost, and its checks.
struct PlanCosts {
  MethodCost dijkstra, virtual_source, fast_marching, exact;
  MethodCost certificate;   ///< Bounds of an approximate answer.
  MethodCost paths;         ///< Following some back through an approximate answer.
  double sample_share = 0;  ///< Of checking one target exactly, as a share of an exact query.
};

}  // namespace gelight
