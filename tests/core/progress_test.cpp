#include "gelight/core/progress.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/transport/log_map.hpp"
#include "gelight/transport/vector_heat.hpp"

using namespace gelight;

namespace {

// What its hook was told, and the question that it answers with yes.
struct Asked {
  int last = -1;
  std::vector<double> done{};
};

CancelHook hook_of(const std::shared_ptr<Asked>& asked) {
  return [asked](double done) {
    asked->done.push_back(done);
    return static_cast<int>(asked->done.size()) == asked->last;
  };
}

// Sets something up with a hook: it is asked for every few thousand vertices from the mesh's first
// on, is told no less than before, and ends the work at whichever question it says so.
template <class SetUp>
void check_asked(const std::string& name, Index vertices, SetUp&& set_up) {
  CAPTURE(name);
  const auto asked = std::make_shared<Asked>();
  set_up(hook_of(asked));
  const std::vector<double> told = asked->done;
  REQUIRE(told.size() >= static_cast<std::size_t>(4 * (vertices / 8192)));
  for (std::size_t i = 1; i < told.size(); ++i) REQUIRE(told[i] >= told[i - 1]);
  const int count = static_cast<int>(told.size());
  for (const int last : {1, 2, count / 3, count / 2, count - 1, count}) {
    CAPTURE(last);
    const auto ended = std::make_shared<Asked>(Asked{last});
    CHECK_THROWS_AS(set_up(hook_of(ended)), Cancelled);
    CHECK(static_cast<int>(ended->done.size()) == last);
  }
}

}  // namespace

TEST_CASE("every set-up asks its hook, from the reading of the mesh on") {
  const Mesh<double> mesh = icosphere<double>(6);
  const auto check = [&](const std::string& name, auto&& set_up) {
    check_asked(name, static_cast<Index>(mesh.positions.size()), set_up);
  };
  check("Surface", [&](const CancelHook& hook) { Surface<double>(mesh, hook); });
  check("Surface of float", [&](const CancelHook& hook) { Surface<float>(mesh, hook); });
  check("Dijkstra", [&](const CancelHook& hook) {
    DijkstraSolver<double>(mesh, DijkstraOptions{.cancelled = hook});
  });
  check("fast marching", [&](const CancelHook& hook) {
    FastMarchingSolver<double>(mesh, FastMarchingOptions{.cancelled = hook});
  });
  check("virtual sources", [&](const CancelHook& hook) {
    VirtualSourceSolver<double>(mesh, VirtualSourceOptions{.cancelled = hook});
  });
  check("exact", [&](const CancelHook& hook) {
    ExactSolver<double>(mesh, ExactOptions<double>{.cancelled = hook});
  });
  check("heat",
        [&](const CancelHook& hook) { HeatSolver<double>(mesh, HeatOptions{.cancelled = hook}); });
  check("smooth", [&](const CancelHook& hook) {
    SmoothDistanceSolver<double>(mesh, SmoothOptions<double>{.cancelled = hook});
  });
  check("vector heat", [&](const CancelHook& hook) {
    VectorHeatSolver<double>(mesh, VectorHeatOptions{.cancelled = hook});
  });
  check("exact log maps", [&](const CancelHook& hook) {
    ExactLogMapSolver<double>(mesh, ExactLogMapOptions{.cancelled = hook});
  });
  check("planner", [&](const CancelHook& hook) {
    DistancePlanner<double>(mesh, PlanRequest{.cancelled = hook});
  });
}

TEST_CASE("a callable that may be told how much is done, or not, is told") {
  double told = -1;
  const CancelHook by_default = [&](double done = 0) { return (told = done) == 2; };
  by_default.check(0.25, "work");
  CHECK(told == 0.25);
  std::size_t count = 0;
  const CancelHook whatever = [&](auto... parts) { return (count = sizeof...(parts)) == 2; };
  whatever.check(0.5, "work");
  CHECK(count == 1);
}

TEST_CASE("a surface is the same with a hook and without") {
  const Mesh<double> mesh = icosphere<double>(5);
  const Surface<double> plain(mesh), asked(mesh, [] { return false; });
  REQUIRE(plain.halfedge_count() == asked.halfedge_count());
  for (Index h = 0; h < plain.halfedge_count(); ++h) {
    REQUIRE(plain.origin(h) == asked.origin(h));
    REQUIRE(plain.twin(h) == asked.twin(h));
    REQUIRE(plain.length(h) == asked.length(h));
  }
}

TEST_CASE(
    "the share that parts of parts tell never decreases, and each ends where the next begins") {
  for (int count = 1; count <= 24; ++count) {
    CAPTURE(count);
    double last = 0;
    int decreases = 0;
    const CancelHook whole([&](double done) {
      decreases += done < last ? 1 : 0;
      last = done;
      return false;
    });
    for (int k = 0; k < count; ++k) {
      const CancelHook part = whole.part(double(k) / count, double(k + 1) / count);
      for (int i = 0; i < 7; ++i) {
        const CancelHook inner = part.part(i / 7.0, (i + 1) / 7.0);
        for (const double done : {0.0, 0.1, 0.9, 1 - 0x1p-53, 1.0}) inner.check(done, "work");
      }
      CHECK(last == double(k + 1) / count);
    }
    CHECK(decreases == 0);
  }
}
