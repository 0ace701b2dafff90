// One thread is all that a page has: work for several comes out the same there. What the test runs.

#include <cstdint>
#include <vector>

#include "gelight/core/parallel.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_rows.hpp"
#include "gelight/mesh/shapes.hpp"
#include "page.hpp"

int differences() {
  int count = 0;
  for (const unsigned threads : {0u, 2u, 7u}) {
    std::vector<int> calls(100);
    gelight::parallel_for(100, threads, [&](gelight::Index i) { ++calls[std::size_t(i)]; });
    count += calls != std::vector<int>(100, 1);
  }
  const gelight::DijkstraSolver<float> solver(gelight::icosphere<float>(1, 1));
  const std::vector<gelight::Index> from{0, 7, 12};
  const auto matrix = [&](unsigned threads) {
    gelight::RowOptions options;
    options.threads = threads;
    return gelight::distance_matrix(solver, std::span(from), options);
  };
  count += matrix(4) != matrix(1);
  return count;
}
