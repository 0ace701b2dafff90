#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gelight/core/progress.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/marching/steiner_graph.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "stress/kept_meshes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/scan_meshes.hpp"

// The exact solver at points where arithmetic cancels: next to vertices and edges, in faces without
// area, on edges of no length, far from the origin.

using gelight::edge_point;
using gelight::ExactOptions;
using gelight::ExactSolver;
using gelight::face_point;
using gelight::Index;
using gelight::Mesh;
using gelight::Source;
using gelight::Surface;
using gelight::SurfacePoint;
using gelight::Vec3;
using gelight::vertex_point;
using gelight::test::longest_edge;
using gelight::test::Random;
using gelight::test::uniform;
using gelight::test::uniform_index;

namespace {

using Point = SurfacePoint<double>;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// The meshes on which something once failed, random small ones of ten kinds, and a scan.
std::vector<Mesh<double>> meshes(int random_ones) {
  std::vector<Mesh<double>> all;
  for (const auto& [name, mesh] : gelight::stress::kept_meshes()) all.push_back(mesh);
  for (int seed = 0; seed < random_ones; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    all.push_back(gelight::test::small_random_mesh(seed, random));
  }
  all.push_back(gelight::grid<double>(3, 3, 3, 3));
  all.push_back(gelight::icosphere<double>(2));
  std::erase_if(all, [](const auto& mesh) { return !gelight::check(mesh).is_accepted(); });
  return all;
}

// A point next to a corner of a face, off it by shares of 10^low to 10^high; sometimes on an edge.
struct NextTo {
  Index face, vertex;
  std::size_t corner;
  double share, to_first;

  NextTo(const Surface<double>& surface, double low, double high, Random& random)
      : face(uniform_index(random, surface.face_count())),
        corner(at(uniform_index(random, 3))),
        share(std::pow(10, uniform(random, low, high))),
        to_first(uniform(random, 0, 1) < 0.3 ? 1 : uniform(random, 0, 1)) {
    vertex = surface.face(face)[corner];
  }
  // The point in this direction from the corner, off it by another share.
  [[nodiscard]] Point off_by(double s) const {
    std::array<double, 3> w{};
    w[(corner + 1) % 3] = s * to_first;
    w[(corner + 2) % 3] = s * (1 - to_first);
    w[corner] = 1 - w[(corner + 1) % 3] - w[(corner + 2) % 3];
    return face_point<double>(face, w);
  }
  [[nodiscard]] Point point() const { return off_by(share); }
};

// By how much distances differ more than the points do from which they are measured, as a share of
// the longest edge.
double excess(const Surface<double>& surface, const std::vector<double>& a,
              const std::vector<double>& b, double gap) {
  double worst = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    if (a[v] == b[v]) continue;
    worst = std::max(worst, std::fabs(a[v] - b[v]) - gap);
  }
  return worst / longest_edge(surface);
}

std::vector<double> distance_from(const ExactSolver<double>& solver, const Point& p) {
  const Source<double> source{p, 0};
  return solver.distance(std::span<const Source<double>>(&source, 1));
}

// The same mesh with a vertex at a point inside a face or on an edge.
Mesh<double> with_vertex(const Surface<double>& surface, Mesh<double> mesh, const Point& p) {
  const Vec3<double> place = surface.position(p);
  const auto v = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back({place[0], place[1], place[2]});
  const auto [v0, v1, v2] = mesh.faces[at(p.element[0])];
  mesh.faces[at(p.element[0])] = {v0, v1, v};
  mesh.faces.push_back({v1, v2, v});
  mesh.faces.push_back({v2, v0, v});
  return mesh;
}

// Moves what a mesh has on a lattice by whole numbers, which loses nothing.
Mesh<double> on_lattice(Mesh<double> mesh, double step) {
  for (auto& p : mesh.positions) {
    for (double& x : p) x = std::round(x / step) * step;
  }
  return mesh;
}
Mesh<double> moved(Mesh<double> mesh, const std::array<double, 3>& by) {
  for (auto& p : mesh.positions) {
    for (std::size_t k = 0; k < 3; ++k) p[k] += by[k];
  }
  return mesh;
}

// A small mesh with caps on edges, T-junctions closed by faces without area, vertices on the edges
// of their faces, and sometimes on a lattice, where many coincide.
Mesh<double> mesh_with_flat_faces(std::uint64_t seed) {
  Random random(seed);
  const bool has_lattice = seed % 4 == 3;
  const Index kind = has_lattice ? uniform_index(random, 10)
                                 : std::array<Index, 4>{2, 5, 1, 3}[at(uniform_index(random, 4))];
  Mesh<double> mesh = gelight::test::small_random_mesh(kind, random);
  if (has_lattice) mesh = on_lattice(std::move(mesh), 0.5);
  for (Index caps = 1 + uniform_index(random, 3); caps > 0; --caps) {
    const auto f = at(uniform_index(random, static_cast<Index>(mesh.faces.size())));
    const auto k = at(uniform_index(random, 3));
    const Index a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3],
                c = mesh.faces[f][(k + 2) % 3];
    const double t =
        std::array{0.0, 0.5, 0.25, 1.0, uniform(random, 0, 1)}[at(uniform_index(random, 5))];
    std::array<double, 3> place{};
    for (std::size_t i = 0; i < 3; ++i) {
      place[i] =
          mesh.positions[at(a)][i] + t * (mesh.positions[at(b)][i] - mesh.positions[at(a)][i]);
    }
    const auto v = static_cast<Index>(mesh.positions.size());
    mesh.positions.push_back(place);
    switch (uniform_index(random, 3)) {
      case 0:
        mesh.faces[f] = {a, v, c};
        mesh.faces.push_back({v, b, c});
        mesh.faces.push_back({a, b, v});
        break;
      case 1:
        mesh.faces.push_back({a, b, v});
        break;
      default:
        mesh.faces[f] = {a, b, v};
        mesh.faces.push_back({b, c, v});
        mesh.faces.push_back({c, a, v});
    }
  }
  return mesh;
}

// A point of a face without area, where there is one, else of any.
Point point_of_flat_face(const Surface<double>& surface, Random& random) {
  std::vector<Index> flat;
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = surface.face(f);
    const Vec3<double> u = surface.position(b) - surface.position(a);
    const Vec3<double> w = surface.position(c) - surface.position(a);
    if (gelight::cross<double>(u, w).norm() < 1e-10) flat.push_back(f);
  }
  const bool anywhere = flat.empty() || uniform(random, 0, 1) < 0.3;
  const Index f = anywhere ? uniform_index(random, surface.face_count())
                           : flat[at(uniform_index(random, static_cast<Index>(flat.size())))];
  const double a = uniform(random, 0, 1), b = uniform(random, 0, 1 - a);
  if (uniform(random, 0, 1) < 0.7) return face_point<double>(f, {a, b, 1 - a - b});
  const auto corners = surface.face(f);
  return edge_point<double>(corners[0], corners[at(1 + uniform_index(random, 2))], a);
}

}  // namespace

TEST_CASE("sources next to vertices: distances as far from the vertex' as the point is off") {
  for (const Mesh<double>& mesh : meshes(40)) {
    const ExactSolver solver(mesh);
    const Surface<double>& surface = solver.surface();
    Random random(5);
    for (int i = 0; i < 60; ++i) {
      const NextTo next(surface, -20, -6, random);
      CAPTURE(next.face);
      CAPTURE(next.share);
      const Point p = next.point(), v = vertex_point<double>(next.vertex);
      const double gap = surface.difference(v, p).norm();
      CHECK(excess(surface, distance_from(solver, p), distance_from(solver, v), gap) < 1e-13);
    }
  }
}

TEST_CASE("sources next to edges: distances as far from the edge's point's as the point is off") {
  for (const Mesh<double>& mesh : meshes(30)) {
    const ExactSolver solver(mesh);
    const Surface<double>& surface = solver.surface();
    Random random(6);
    for (int i = 0; i < 40; ++i) {
      const Index f = uniform_index(random, surface.face_count());
      const double share = std::pow(10, uniform(random, -20, -6)), t = uniform(random, 0.05, 0.95);
      const Point p = face_point<double>(f, {(1 - t) * (1 - share), t * (1 - share), share});
      const Point on_edge = edge_point<double>(surface.face(f)[0], surface.face(f)[1], t);
      const double gap = surface.difference(on_edge, p).norm();
      CHECK(excess(surface, distance_from(solver, p), distance_from(solver, on_edge), gap) < 1e-13);
    }
  }
}

TEST_CASE("at any scale, far from the origin and in float: sources next to vertices") {
  Random random(8);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (int seed = 0; seed < 20; ++seed) {
      Mesh<double> mesh = on_lattice(gelight::test::small_random_mesh(seed, random), 1.0 / 1024);
      mesh = moved(std::move(mesh), {1e6, -2e6, 5e5});
      Mesh<float> single;
      for (auto& p : mesh.positions) {
        for (double& x : p) x *= scale;
      }
      if (!gelight::check(mesh).is_accepted()) continue;
      const ExactSolver solver(mesh);
      const NextTo next(solver.surface(), -20, -6, random);
      const double gap =
          solver.surface().difference(vertex_point<double>(next.vertex), next.point()).norm();
      CHECK(excess(solver.surface(), distance_from(solver, next.point()),
                   distance_from(solver, vertex_point<double>(next.vertex)), gap) < 1e-13);
    }
  }
  const Mesh<float> ball = gelight::icosphere<float>(2);
  const ExactSolver<float> solver(ball);
  for (const float share : {1e-6F, 1e-12F, 1e-17F, 1e-20F}) {
    for (Index f = 0; f < 40; ++f) {
      const Source<float> source{face_point<float>(f, {1 - 2 * share, share, share}), 0};
      const auto d = solver.distance(std::span<const Source<float>>(&source, 1));
      const auto from_vertex = solver.distance(ball.faces[at(f)][0]);
      for (std::size_t v = 0; v < d.size(); ++v) {
        CHECK(std::fabs(d[v] - from_vertex[v]) < 2 * share + 1e-6F);
      }
    }
  }
}

TEST_CASE("queries next to vertices: distances as at the vertex, directions as farther out") {
  int count = 0, off = 0;
  for (const Mesh<double>& mesh : meshes(40)) {
    const ExactSolver solver(mesh);
    const Surface<double>& surface = solver.surface();
    const double longest = longest_edge(surface);
    Random random(7);
    for (int i = 0; i < 12; ++i) {
      const NextTo next(surface, -20, -7, random);
      const Index source = uniform_index(random, surface.vertex_count());
      if (source == next.vertex) continue;
      const Point p = next.point(), v = vertex_point<double>(next.vertex);
      const auto back = solver.solve(p);
      for (const bool keep : {true, false}) {
        const auto field = solver.solve(source, {.keep_windows = keep});
        const double d = field.distance(p);
        if (!(d < gelight::unreachable<double>)) continue;
        const double gap = surface.difference(v, p).norm();
        CHECK(std::fabs(d - field.distance(next.vertex)) <= gap + 1e-13 * std::max(d, longest));
        CHECK(back.distance(source) == gelight::test::approx(d).epsilon(1e-11));
        if (d < 1e-3 * longest) continue;
        const Vec3<double> direction = field.direction(p);
        CHECK(direction.norm() == gelight::test::approx(1));
        CHECK(field.arrivals(p).front().direction.norm() == gelight::test::approx(1));
        const Vec3<double> departure = back.departure(source).direction;
        CHECK(departure.norm() == gelight::test::approx(1));
        // A plane round a vertex looks alike at every scale; but where a path from the other side
        // is nearly as short, all of those count.
        const double tie = 1e-9 + 3e-5 * longest / d;
        double here = 2, there = 2;
        for (const Point& q : {next.off_by(1e-5), next.off_by(1e-6), v}) {
          for (const auto& arrival : field.arrivals(q, tie)) {
            here = std::min(here, (arrival.direction - direction).norm());
            there = std::min(there, (arrival.direction + departure).norm());
          }
        }
        ++count;
        // Faces without area and coincident vertices lie in no plane: there sides may differ.
        off += here > 1e-2 || there > 1e-2;
      }
    }
  }
  CHECK(count > 500);
  CHECK(off <= count / 200);
}

TEST_CASE("the light of pixels that see vertices") {
  const Mesh<double> ball = gelight::icosphere<double>(3);
  const ExactSolver solver(ball);
  const Surface<double>& surface = solver.surface();
  const auto led = vertex_point<double>(0);
  std::vector<Point> points, vertices;
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const NextTo next(surface, -18, -14, random);
    if (next.vertex == 0) continue;
    points.push_back(next.point());
    vertices.push_back(vertex_point<double>(next.vertex));
  }
  const auto light = gelight::geodesic_field<double>(solver, led, points);
  const auto right = gelight::geodesic_field<double>(solver, led, vertices);
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Faces at a vertex make an angle of less than 0.2 with each other here.
    const bool at_antipode = solver.solve(Index{0}).arrivals(vertices[i], 1e-6).size() > 1;
    if (!at_antipode) CHECK((light[i] - right[i]).norm() < 0.2);
  }
}

TEST_CASE("as if a vertex were there, however small the shares; several sources, any start") {
  std::vector<Mesh<double>> all = meshes(60);
  for (const auto& [name, mesh] : gelight::test::scan_meshes(1)) all.push_back(mesh);
  for (const Mesh<double>& mesh : all) {
    const ExactSolver solver(mesh);
    const Surface<double>& surface = solver.surface();
    const double longest = longest_edge(surface);
    Random random(9);
    for (int i = 0; i < 6; ++i) {
      const auto anywhere = [&] {
        std::array<double, 3> w{};
        for (double& x : w) x = std::pow(10, uniform(random, -20, 0));
        const double sum = w[0] + w[1] + w[2];
        for (double& x : w) x /= sum;
        return face_point<double>(uniform_index(random, surface.face_count()), w);
      };
      std::vector<Source<double>> sources{{anywhere(), uniform(random, -0.5, 0.5) * longest}};
      for (Index more = uniform_index(random, 3); more > 0; --more) {
        sources.push_back({anywhere(), uniform(random, -0.5, 0.5) * longest});
      }
      const std::span<const Source<double>> span(sources);
      const auto kept = solver.solve(span, {.keep_windows = true});
      const auto searched = solver.solve(span);
      // Each by itself, from a mesh that has it for a vertex.
      std::vector<double> right(mesh.positions.size(), gelight::unreachable<double>);
      for (const auto& source : sources) {
        const Mesh<double> split = with_vertex(surface, mesh, source.point);
        const auto d = ExactSolver(split).distance(static_cast<Index>(mesh.positions.size()));
        for (std::size_t v = 0; v < right.size(); ++v) {
          right[v] = std::min(right[v], source.distance + d[v]);
        }
      }
      CHECK(excess(surface, kept.distances(), right, 0) < 1e-11);
      const Point q = anywhere();
      const double d = kept.distance(q);
      double other_way = gelight::unreachable<double>;
      const auto from_there = solver.solve(q, {.keep_windows = true});
      for (const auto& source : sources) {
        other_way = std::min(other_way, source.distance + from_there.distance(source.point));
      }
      if (d == other_way) continue;
      CHECK(std::fabs(d - searched.distance(q)) < 1e-12 * std::max(std::fabs(d), longest));
      CHECK(std::fabs(d - other_way) < 1e-12 * std::max(std::fabs(d), longest));
    }
  }
}

TEST_CASE("faces without area and edges of no length: between straight lines and Steiner graphs") {
  for (std::uint64_t seed = 0; seed < 250; ++seed) {
    const Mesh<double> mesh = mesh_with_flat_faces(seed);
    if (!gelight::check(mesh).is_accepted()) continue;
    CAPTURE(seed);
    Random random(seed + 77);
    const ExactSolver solver(mesh);
    const Surface<double>& surface = solver.surface();
    const double rounding = 1e-12 * longest_edge(surface);
    const Point p = point_of_flat_face(surface, random);
    const auto kept = solver.solve(p, {.keep_windows = true}), searched = solver.solve(p);
    const auto longer = gelight::detail::SteinerGraph<double>(surface, 12).distance({{p, 0}});
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      const double d = kept.distance(v);
      if (d == longer[v]) continue;
      CHECK(d <= longer[v] + rounding);
      CHECK(d >= surface.difference(p, vertex_point<double>(v)).norm() - rounding);
      CHECK(std::fabs(gelight::length(surface, searched.path(v)) - d) < 1e2 * rounding);
    }
    for (int i = 0; i < 4; ++i) {
      const Point q = point_of_flat_face(surface, random);
      const double d = kept.distance(q);
      if (!(d < gelight::unreachable<double>)) continue;
      CHECK(std::fabs(searched.distance(q) - d) < rounding);
      CHECK(std::fabs(solver.solve(q, {.keep_windows = true}).distance(p) - d) < rounding);
      if (d < 1e-9) continue;
      CHECK(kept.direction(q).norm() == gelight::test::approx(1));
      CHECK(searched.direction(q).norm() == gelight::test::approx(1));
    }
  }
}

TEST_CASE("moved by whole numbers nothing changes: distances, directions and proved bounds") {
  Random random(12);
  for (int seed = 0; seed < 60; ++seed) {
    const Mesh<double> mesh =
        on_lattice(gelight::test::small_random_mesh(seed, random), 1.0 / 4096);
    if (!gelight::check(mesh).is_accepted()) continue;
    CAPTURE(seed);
    const Mesh<double> far = moved(mesh, {1e6, -3e6, 7e5});
    std::vector<Source<double>> sources{{gelight::test::random_point(mesh, random), 0.25}};
    sources.push_back({gelight::test::random_point(mesh, random), -0.5});
    const std::span<const Source<double>> span(sources);
    const Point q = gelight::test::random_point(mesh, random);
    for (const bool keep : {true, false}) {
      const auto here = ExactSolver(mesh).solve(span, {.keep_windows = keep});
      const auto there = ExactSolver(far).solve(span, {.keep_windows = keep});
      CHECK(here.distances() == there.distances());
      CHECK(here.distance(q) == there.distance(q));
      CHECK(here.direction(q) == there.direction(q));
      CHECK(gelight::length(Surface<double>(far), there.path(q)) ==
            gelight::length(Surface<double>(mesh), here.path(q)));
    }
    const auto exact = ExactSolver(far).distance(span);
    const auto bounds = gelight::Certifier(far).bounds(span, std::span<const double>(exact));
    const auto same = gelight::Certifier(mesh).bounds(span, std::span<const double>(exact));
    CHECK(bounds.lower == same.lower);
    CHECK(bounds.upper == same.upper);
    for (std::size_t v = 0; v < exact.size(); ++v) {
      if (exact[v] == gelight::unreachable<double>) continue;
      const double rounding = 1e-14 * (1 + std::fabs(exact[v]));
      CHECK(bounds.lower[v] <= exact[v] + rounding);
      CHECK(bounds.upper[v] >= exact[v] - rounding);
    }
  }
}

namespace {

// The faces of a grid of n^3 cubes, each of six tetrahedra: many faces on each edge.
Mesh<double> skeleton_of_tetrahedra(Index n) {
  Mesh<double> mesh;
  const auto number = [n](Index x, Index y, Index z) { return (z * n + y) * n + x; };
  for (Index z = 0; z < n; ++z) {
    for (Index y = 0; y < n; ++y) {
      for (Index x = 0; x < n; ++x) {
        mesh.positions.push_back({double(x), double(y), double(z)});
      }
    }
  }
  std::set<std::array<Index, 3>> faces;
  for (Index cell = 0; cell < (n - 1) * (n - 1) * (n - 1); ++cell) {
    const Index x = cell % (n - 1), y = cell / (n - 1) % (n - 1), z = cell / (n - 1) / (n - 1);
    std::array<std::size_t, 3> axes{0, 1, 2};
    do {
      std::array<Index, 3> at_corner{x, y, z};
      std::array<Index, 4> corners{number(x, y, z)};
      for (std::size_t k = 0; k < 3; ++k) {
        ++at_corner[axes[k]];
        corners[k + 1] = number(at_corner[0], at_corner[1], at_corner[2]);
      }
      for (std::size_t skipped = 0; skipped < 4; ++skipped) {
        std::array<Index, 3> face{};
        std::copy_if(corners.begin(), corners.end(), face.begin(),
                     [&](Index v) { return v != corners[skipped]; });
        std::sort(face.begin(), face.end());
        faces.insert(face);
      }
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  mesh.faces.assign(faces.begin(), faces.end());
  return mesh;
}

}  // namespace

TEST_CASE("a limit of memory: refused in time, usable afterwards, and no hindrance to what fits") {
  const Mesh<double> mesh = skeleton_of_tetrahedra(6);
  const ExactSolver solver(mesh);
  const auto free = solver.solve(Index{0}).distances();
  CHECK_THROWS_AS((void)solver.solve(Index{0}, {.max_memory = 100'000}), gelight::MemoryLimit);
  const ExactSolver limited(mesh, {.max_memory = 100'000});
  CHECK_THROWS_AS((void)limited.distance(Index{0}), gelight::MemoryLimit);
  CHECK(solver.solve(Index{0}, {.max_memory = 100'000'000}).distances() == free);
  CHECK(solver.distance(Index{0}) == free);
  // What vertices tell takes no windows; a query that searches back does.
  const Mesh<double> ball = gelight::icosphere<double>(3);
  const std::size_t enough = 4'000'000;
  const auto field = ExactSolver(ball).solve(Index{0}, {.max_memory = enough});
  const auto middle = face_point<double>(700, {0.2, 0.3, 0.5});
  const double d = ExactSolver(ball).solve(Index{0}, {.keep_windows = true}).distance(middle);
  CHECK(field.distance(middle) == gelight::test::approx(d).epsilon(1e-13));
}

TEST_CASE("the hook is told how much is done, and ends queries and bounds, too") {
  const Mesh<double> ball = gelight::icosphere<double>(4);
  const ExactSolver solver(ball);
  double before = 0;
  int asked = 0, answer_at = 0;
  const gelight::CancelHook hook = [&](double done) {
    CHECK(done >= before);
    CHECK(done <= 1);
    before = done;
    return ++asked == answer_at;
  };
  const auto field = solver.solve(Index{0}, {.cancelled = hook});
  CHECK(asked > 4);
  CHECK(before > 0.5);
  const auto far = face_point<double>(3000, {0.2, 0.3, 0.5});
  before = 0;
  const double d = field.distance(far);
  for (const int at : {1, 2}) {
    before = asked = 0;
    answer_at = at;
    CHECK_THROWS_AS((void)field.distance(far), gelight::Cancelled);
    CHECK(asked == at);
  }
  before = asked = answer_at = 0;
  CHECK(field.distance(far) == d);

  const gelight::Certifier certifier(ball);
  const std::vector<double> distances = field.distances();
  before = asked = 0;
  const auto bounds = certifier.bounds(Index{0}, std::span<const double>(distances), hook);
  const int all = asked;
  CHECK(all > 4);
  for (answer_at = 1; answer_at <= all; ++answer_at) {
    before = asked = 0;
    CHECK_THROWS_AS((void)certifier.bounds(Index{0}, std::span<const double>(distances), hook),
                    gelight::Cancelled);
    CHECK(asked == answer_at);
  }
  before = 0;
  answer_at = 0;
  CHECK(certifier.bounds(Index{0}, std::span<const double>(distances), hook).upper == bounds.upper);
}

TEST_CASE("two vertices at one place but for rounding, a face between them: as if it were closed") {
  for (int seed = 0; seed < 80; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Mesh<double> mesh = gelight::test::small_random_mesh(2, random);
    // A face beside an edge, from its end to a vertex that is that end but for rounding.
    const auto f = at(uniform_index(random, static_cast<Index>(mesh.faces.size())));
    const auto [a, b, c] = mesh.faces[f];
    const double off = std::pow(10, uniform(random, -17, -13));
    const auto v = static_cast<Index>(mesh.positions.size());
    auto place = mesh.positions[at(a)];
    for (double& x : place) x += uniform(random, -off, off);
    mesh.positions.push_back(place);
    mesh.faces[f] = {a, b, v};
    mesh.faces.push_back({b, c, v});
    mesh.faces.push_back({c, a, v});
    CAPTURE(seed);
    const ExactSolver solver(mesh);
    const gelight::detail::SteinerGraph<double> graph(solver.surface(), 12);
    for (Index source = 0; source < v; source += 5) {
      const auto d = solver.distance(source);
      const auto longer = graph.distance({{vertex_point<double>(source), 0}});
      for (Index u = 0; u <= v; ++u) {
        CHECK(d[at(u)] <= longer[u] + 1e-12);
        CHECK(d[at(u)] == gelight::test::approx(solver.distance(u)[at(source)]).epsilon(1e-11));
      }
    }
  }
}

TEST_CASE("within a greatest distance ways are found back as without it, on needles too") {
  for (const auto& mesh : meshes(60)) {
    const ExactSolver solver(mesh);
    const double longest = longest_edge(solver.surface());
    for (int seed = 0; seed < 6; ++seed) {
      Random random(static_cast<std::uint64_t>(seed));
      const Source<double> source{gelight::test::random_point(mesh, random), 0};
      const auto sources = std::span<const Source<double>>(&source, 1);
      ExactOptions<double> near;
      near.max_distance = longest * uniform(random, 0.05, 0.8);
      near.keep_windows = seed % 2 == 0;
      const auto all = solver.solve(sources, ExactOptions<double>{});
      const auto some = solver.solve(sources, near);
      for (int i = 0; i < 40; ++i) {
        const Point p = i % 4 == 3 ? NextTo(solver.surface(), -14, -3, random).point()
                                   : gelight::test::random_point(mesh, random);
        const double d = all.distance(p), of_some = some.distance(p);
        const auto path = some.path(p);
        CHECK(path.empty() == std::isinf(of_some));
        if (std::isinf(of_some)) {
          CHECK(d > near.max_distance - 1e-12 * longest);
          continue;
        }
        CHECK(std::fabs(of_some - d) <= 1e-12 * longest);
        CHECK(std::fabs(gelight::length(solver.surface(), path) - d) <= 1e-9 * longest);
      }
    }
  }
}
