#include <doctest/doctest.h>

#include <cstddef>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/heap_count.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;

namespace {

// Two parts, so that start distances are moved in each on its own.
Mesh<double> two_parts(const Mesh<double>& mesh) {
  Mesh<double> beside = mesh;
  for (auto& p : beside.positions) p[0] += 5;
  return joined<double>(std::vector{mesh, beside});
}

// A vertex, several vertices, and points of every kind with start distances of both signs.
template <class T>
struct Question {
  std::vector<Index> vertices;
  std::vector<Source<T>> sources;
};
template <class T>
std::vector<Question<T>> questions(const Surface<double>& surface) {
  std::mt19937 random(7);
  const auto below = [&](Index count) {
    return static_cast<Index>(random() % static_cast<unsigned>(count));
  };
  std::vector<Question<T>> out;
  for (const int count : {1, 1, 3, 6}) {
    Question<T> question;
    for (int i = 0; i < count; ++i) {
      question.vertices.push_back(below(surface.vertex_count()));
      const auto face = surface.face(below(surface.face_count()));
      const auto at = [&](int kind) {
        if (kind == 0) return vertex_point<T>(face[0]);
        if (kind == 1) return edge_point<T>(face[0], face[1], T{0.25});
        return face_point<T>(below(surface.face_count()), {T{0.25}, T{0.5}, T{0.25}});
      };
      question.sources.push_back({at(i % 3), static_cast<T>(0.05 * i - 0.1)});
    }
    out.push_back(question);
  }
  return out;
}

// What a solver says to each in turn.
template <class T>
void ask_all(const auto& solver, const std::vector<Question<T>>& asked, std::vector<T>& out,
             const auto& take) {
  for (const auto& [vertices, sources] : asked) {
    solver.distance_into(out, vertices[0]);
    take();
    solver.distance_into(out, std::span<const Index>(vertices));
    take();
    solver.distance_into(out, std::span<const Source<T>>(sources));
    take();
  }
}

template <class T>
void check_queries(const auto& make_solver, const std::string& name) {
  CAPTURE(name);
  const auto solver = make_solver();
  const auto asked = questions<T>(solver.surface());
  std::vector<T> out(static_cast<std::size_t>(solver.surface().vertex_count()));
  // Buffers change places while they grow, so some rounds until each has been everywhere.
  for (int round = 0; round < 4; ++round) ask_all(solver, asked, out, [] {});

  const std::size_t before = test::bytes_taken;
  ask_all(solver, asked, out, [] {});
  CHECK(test::bytes_taken - before == 0);

  // What is left of other questions changes no answer.
  std::vector<std::vector<T>> answers;
  ask_all(solver, asked, out, [&] { answers.push_back(out); });
  std::vector<std::vector<T>> fresh;
  for (const auto& [vertices, sources] : asked) {
    fresh.push_back(make_solver().distance(vertices[0]));
    fresh.push_back(make_solver().distance(std::span<const Index>(vertices)));
    fresh.push_back(make_solver().distance(std::span<const Source<T>>(sources)));
  }
  CHECK(answers == fresh);
}

template <class T>
Mesh<T> in_type(const Mesh<double>& mesh) {
  Mesh<T> as{{}, mesh.faces};
  for (const auto& p : mesh.positions) {
    as.positions.push_back({static_cast<T>(p[0]), static_cast<T>(p[1]), static_cast<T>(p[2])});
  }
  return as;
}

template <class T>
void check_smooth(const Mesh<double>& mesh) {
  const auto as = in_type<T>(mesh);
  check_queries<T>([&] { return SmoothDistanceSolver<T>(as); }, "smooth");
}

template <class T>
void check_solvers(const Mesh<double>& mesh) {
  const auto as = in_type<T>(mesh);
  check_queries<T>([&] { return DijkstraSolver<T>(as); }, "edges");
  check_queries<T>([&] { return DijkstraSolver<T>(as, {.steiner_points = 2}); }, "Steiner points");
  check_queries<T>([&] { return FastMarchingSolver<T>(as); }, "fast marching");
  check_queries<T>([&] { return VirtualSourceSolver<T>(as); }, "virtual sources");
  check_queries<T>([&] { return ExactSolver<T>(as); }, "exact");
  const auto corner = as.faces[as.faces.size() / 2];
  const std::vector targets{vertex_point<T>(corner[0]), edge_point<T>(corner[0], corner[1], T{0.5}),
                            face_point<T>(3, {T{0.5}, T{0.25}, T{0.25}})};
  check_queries<T>([&] { return ExactSolver<T>(as, {.targets = targets}); }, "exact, to targets");
  check_queries<T>([&] { return HeatSolver<T>(as); }, "heat");
  check_queries<T>([&] { return HeatSolver<T>(as, {.refinements = 2}); }, "heat, refined");
  check_queries<T>([&] { return HeatSolver<T>(as, {.intrinsic_delaunay = false}); },
                   "heat, the mesh's own triangles");
}

// From the mesh to the first answer: all that was taken, at whatever time, so that no peak is
// higher.
template <class Solver>
std::size_t bytes_a_vertex() {
  const auto mesh = icosphere<double>(6);
  const std::size_t before = test::bytes_taken;
  const Solver solver(mesh);
  const auto distance = solver.distance(7);
  const std::size_t taken = test::bytes_taken - before;
  CHECK(distance[7] == 0);
  return taken / mesh.positions.size();
}

// Of a query from 48 sources an edge along a strip's end, and whether it is right beyond one edge.
template <class Solver>
std::size_t bytes_a_vertex_from_side_by_side() {
  const auto mesh = grid<double>(6, 100, 0.6, 10.0);
  const Solver solver(mesh);
  std::vector<Source<double>> sources;
  for (Index v = 0; v < 6; ++v) {
    for (int i = 0; i < 48; ++i) {
      sources.push_back({edge_point<double>(v, v + 1, (i + 0.5) / 48), 0});
    }
  }
  std::vector<double> distance(mesh.positions.size());
  const std::size_t before = test::bytes_taken;
  solver.distance_into(distance, std::span<const Source<double>>(sources));
  const std::size_t taken = test::bytes_taken - before;
  for (std::size_t v = 7; v < distance.size(); ++v) {
    CHECK(distance[v] == gelight::test::approx(mesh.positions[v][1]).epsilon(0.005));
  }
  return taken / mesh.positions.size();
}

}  // namespace

TEST_CASE("distance_into takes no memory for a question of a kind it was asked before") {
  for (const Mesh<double>& mesh :
       {test::scans::blob(2), two_parts(torus<double>(1.0, 0.3, 40, 16))}) {
    check_solvers<double>(mesh);
    check_solvers<float>(mesh);
    check_smooth<double>(mesh);
    check_smooth<float>(mesh);
  }
  // A long one, so that queues pass their numbers of buckets many times. (Smooth distances have
  // none of their own.)
  const auto strip = grid<double>(6, 400, 1.0, 30.0);
  check_solvers<double>(strip);
  check_solvers<float>(strip);
}

TEST_CASE(
    "Dijkstra's method takes less than 105 bytes a vertex from the mesh to its first answer") {
  CHECK(bytes_a_vertex<DijkstraSolver<double>>() < 105);
}

TEST_CASE("fast marching takes less than 400 bytes a vertex from the mesh to its first answer") {
  CHECK(bytes_a_vertex<FastMarchingSolver<double>>() < 400);
}

// Without a limit most of 288 waves come to every vertex: 36,000 and 85,000 bytes.
TEST_CASE("of sources side by side a vertex keeps the nearest waves") {
  CHECK(bytes_a_vertex_from_side_by_side<FastMarchingSolver<double>>() < 23000);
  CHECK(bytes_a_vertex_from_side_by_side<VirtualSourceSolver<double>>() < 50000);
}
