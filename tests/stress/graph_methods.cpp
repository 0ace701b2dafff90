#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "stress/query.hpp"

namespace gelight::stress {

// Fast marching reaches a vertex again only if that gains 1e-5, virtual sources 1e-10 (theirs are
// the shares of one step; over a path they add up).
std::vector<Method> graph_methods() {
  return {{"Dijkstra", maker<DijkstraSolver>(), true, true},
          {"fast marching", maker<FastMarchingSolver>(), true, false, 1e-3, 0.5},
          {"virtual source", maker<VirtualSourceSolver>(), true, false, 1e-8, 0.5}};
}

}  // namespace gelight::stress
