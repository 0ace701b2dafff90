#include <doctest/doctest.h>

#include <cstddef>
#include <thread>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "stress/stress.hpp"

// One solver, one field, one renderer, asked from eight threads at once: each gets what one thread
// alone gets. Run under the thread sanitizer by the preset `thread`.

using namespace gelight;

namespace {

constexpr Index threads = 8;

/// What `ask(0)` to `ask(7)` answer, one after the other and then all at once.
template <class Ask>
void check_together(const Ask& ask) {
  using Answer = decltype(ask(Index{0}));
  std::vector<Answer> alone(threads), together(threads);
  for (Index k = 0; k < threads; ++k) alone[static_cast<std::size_t>(k)] = ask(k);
  {
    std::vector<std::jthread> running;
    for (Index k = 0; k < threads; ++k) {
      running.emplace_back([&, k] {
        for (int again = 0; again < 3; ++again) together[static_cast<std::size_t>(k)] = ask(k);
      });
    }
  }
  CHECK(alone == together);
}

}  // namespace

TEST_CASE("every distance solver") {
  const auto mesh = icosphere<double>(3);
  for (const auto& method : stress::methods()) {
    for (const auto precision : {stress::Precision::in_double, stress::Precision::in_float}) {
      CAPTURE(method.name);
      const auto query = method.make(mesh, precision);
      check_together([&](Index k) { return query->distance(stress::from(70 * k)); });
    }
  }
}

TEST_CASE("exact fields: paths and directions, with windows and without") {
  const auto mesh = icosphere<double>(3);
  const ExactSolver solver(mesh);
  for (const bool keep_windows : {false, true}) {
    const auto field = solver.solve(Index{5}, {.keep_windows = keep_windows});
    check_together([&](Index k) {
      return field.path(face_point<double>(90 * k, {0.2, 0.3, 0.5}));
    });
    check_together([&](Index k) { return Vec3<double>(field.direction(81 * k)); });
  }
}

TEST_CASE("vectors and log maps, the factors made on first use") {
  const VectorHeatSolver solver(icosphere<double>(3));
  check_together([&](Index k) { return solver.transport(60 * k, Vec3<double>(1, 2, 3)); });
  check_together([&](Index k) { return solver.log_map(60 * k); });
}

TEST_CASE("the tactile renderer") {
  const Camera<float> camera{60, 60, 31.5f, 23.5f, 64, 48};
  const std::vector<Light<float>> lights{
      {Image<Vec3<float>>(64, 48, Vec3<float>(1, 0, 0.2f).normalized()), {1, 0.5f, 0}}};
  const TactileRenderer<float> renderer(camera, Image<float>(64, 48, 0.03f), lights);
  check_together([&](Index k) {
    Image<float> depth(64, 48, 0.03f);
    depth(20 + k, 20) = 0.028f;
    return renderer.render(depth);
  });
}
