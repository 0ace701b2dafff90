#include "gelight/geodesic/trace.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/log_map.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Random;

namespace {

constexpr double pi = std::numbers::pi;

SurfacePoint<double> random_point(const Surface<double>& surface, int kind, Random& random) {
  const Index f = test::uniform_index(random, surface.face_count());
  const double a = test::uniform(random, 0.1, 0.5), b = test::uniform(random, 0.1, 0.4);
  if (kind == 0) return vertex_point<double>(surface.face(f)[0]);
  if (kind == 1) return edge_point(surface.face(f)[0], surface.face(f)[1], a);
  return face_point<double>(f, {a, b, 1 - a - b});
}

// Whether each piece is in a face: the points' elements are in one.
void check_pieces(const Surface<double>& surface, const Path<double>& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    bool in_face = false;
    for (Index f = 0; f < surface.face_count() && !in_face; ++f) {
      const auto corners = surface.face(f);
      const auto holds = [&](const SurfacePoint<double>& p) {
        if (p.kind == SurfacePoint<double>::Kind::face) return p.element[0] == f;
        const auto has = [&](Index v) {
          return std::find(corners.begin(), corners.end(), v) != corners.end();
        };
        return has(p.element[0]) &&
               (p.kind == SurfacePoint<double>::Kind::vertex || has(p.element[1]));
      };
      in_face = holds(path[i - 1]) && holds(path[i]);
    }
    CHECK(in_face);
  }
}

}  // namespace

TEST_CASE("on a flat sheet it is the straight line") {
  Random random(1);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Mesh<double> mesh = test::jittered_grid(14, 0.25, random);
    for (auto& p : mesh.positions) {
      for (double& x : p) x = scale * (x + 1e3);
    }
    const Surface<double> surface(mesh);
    for (int i = 0; i < 60; ++i) {
      const auto from = random_point(surface, i % 3, random);
      const double angle = test::uniform(random, -pi, pi);
      const Vec3<double> d(std::cos(angle), std::sin(angle), 0);
      const Vec3<double> p = surface.position(from);
      const double wanted = scale * test::uniform(random, 0.1, 6);
      const auto path = trace_geodesic(surface, from, d, wanted);
      const Vec3<double> end = surface.position(path.back());
      const double gone = length(surface, path);
      CHECK((end - p - gone * d).norm() <= 1e-11 * scale);
      CHECK(gone <= wanted * (1 + 1e-13));
      if (gone >= wanted * (1 - 1e-12)) continue;
      // Then it met the border.
      const auto last = path.back();
      bool is_border = false;
      if (last.kind == SurfacePoint<double>::Kind::edge) {
        is_border = surface.is_border(surface.find_halfedge(last.element[0], last.element[1]));
      } else if (last.kind == SurfacePoint<double>::Kind::vertex) {
        for (const Index h : surface.corners(last.element[0])) {
          is_border |= surface.is_border(h) || surface.is_border(Surface<double>::previous(h));
        }
      }
      CHECK(is_border);
    }
  }
}

TEST_CASE("on a flat sheet it is the straight line from places next to vertices, too") {
  Random random(3);
  const Mesh<double> mesh = test::jittered_grid(8, 0.25, random);
  const Surface<double> surface(mesh);
  for (int i = 0; i < 4000; ++i) {
    // Beside a vertex, towards another one near it or anywhere.
    const Index f = test::uniform_index(random, surface.face_count());
    const double share = std::pow(10, test::uniform(random, -15.5, -2));
    const double part = test::uniform(random, 0, 1);
    std::array<double, 3> weights{part * share, (1 - part) * share, 1 - share};
    std::rotate(weights.begin(), weights.begin() + i % 3, weights.end());
    const auto from = face_point<double>(f, weights);
    const Vec3<double> p = surface.position(from);
    const double angle = test::uniform(random, -pi, pi);
    Vec3<double> d(std::cos(angle), std::sin(angle), 0);
    if (i % 2 == 0) {
      const auto other = test::uniform_index(random, surface.vertex_count());
      const Vec3<double> way = surface.position(other) - p;
      if (way.norm() > 0.01 && way.norm() < 4) d = way.normalized();
    }
    const double wanted = test::uniform(random, 0.1, 4);
    const auto path = trace_geodesic(surface, from, d, wanted);
    const double gone = length(surface, path);
    // (It passes through a vertex, or along an edge, that it would miss by 1e-10 of the edge.)
    CHECK((surface.position(path.back()) - p - gone * d).norm() <= 2e-10);
    CHECK(gone <= wanted + 1e-13);
    // It goes as far as was asked, or to the border, which it does not run along.
    const auto last = path.back();
    const bool is_inside =
        last.kind == SurfacePoint<double>::Kind::face ||
        (last.kind == SurfacePoint<double>::Kind::edge &&
         !surface.is_border(surface.find_halfedge(last.element[0], last.element[1])));
    if (is_inside) CHECK(gone == gelight::test::approx(wanted).epsilon(1e-12));
  }
}

TEST_CASE("along grid lines, through vertices and along a border") {
  const auto mesh = grid<double>(8, 8, 8, 8);
  const Surface<double> surface(mesh);
  Index corner = 0, far = 0;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const auto p = surface.position(v);
    if (p[0] + p[1] < surface.position(corner)[0] + surface.position(corner)[1]) corner = v;
    if (p[0] + p[1] > surface.position(far)[0] + surface.position(far)[1]) far = v;
  }
  const Vec3<double> diagonal = surface.position(far) - surface.position(corner);
  const auto path =
      trace_geodesic(surface, vertex_point<double>(corner), diagonal, diagonal.norm());
  CHECK((surface.position(path.back()) - surface.position(far)).norm() < 1e-12);
  const Vec3<double> side(diagonal[0], 0, 0);
  const auto border = trace_geodesic(surface, vertex_point<double>(corner), side, side.norm());
  CHECK((surface.position(border.back()) - surface.position(corner) - side).norm() < 1e-12);
  CHECK(trace_geodesic(surface, vertex_point<double>(corner), Vec3<double>(side), 100.0).size() ==
        border.size());
}

TEST_CASE("what leaves in the direction of a shortest path arrives at its end") {
  Random random(7);
  for (const test::NamedMesh& named : test::scan_meshes(2)) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const Surface<double> surface(mesh);
    const ExactSolver solver(mesh);
    for (int i = 0; i < 6; ++i) {
      const auto from = random_point(surface, i % 3, random);
      const ExactField<double> field = solver.solve(from);
      for (int j = 0; j < 6; ++j) {
        const auto to = random_point(surface, j % 3, random);
        const double distance = field.distance(to);
        if (!(distance > 0) || !std::isfinite(distance)) continue;
        // Paths that bend at vertices on the way are shortest, not straightest.
        const auto shortest = field.path(to);
        bool bends = false;
        for (std::size_t k = 1; k + 1 < shortest.size(); ++k) {
          bends |= shortest[k].kind == SurfacePoint<double>::Kind::vertex;
        }
        if (bends) continue;
        const auto leaves = field.departure(to);
        const auto path = trace_geodesic(surface, from, leaves.direction, distance);
        const double off = (surface.position(path.back()) - surface.position(to)).norm();
        CHECK(off < 1e-9 * distance);
        CHECK(length(surface, path) == gelight::test::approx(distance).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("it undoes the exact log map") {
  Random random(9);
  Mesh<double> saddle = test::jittered_grid(16, 0.2, random);
  for (auto& [x, y, z] : saddle.positions) z = 0.05 * (x - 8) * (y - 8);
  for (const auto& mesh :
       {test::scans::blob(2), icosphere<double>(2), box<double>(1, 2, 3), saddle}) {
    const Surface<double> surface(mesh);
    const ExactLogMapSolver solver(mesh);
    for (int i = 0; i < 12; ++i) {
      const auto from = random_point(surface, i % 3, random);
      const auto map = solver.solve(from);
      const auto& [x, y] = map.tangent_basis();
      for (int j = 0; j < 10; ++j) {
        const auto to = random_point(surface, j % 3, random);
        const auto shortest = map.field().path(to);
        bool bends = shortest.size() < 2;
        for (std::size_t k = 1; k + 1 < shortest.size(); ++k) {
          bends |= shortest[k].kind == SurfacePoint<double>::Kind::vertex;
        }
        if (bends) continue;
        const Vec2<double> at = map(to);
        const auto path =
            trace_geodesic(surface, from, Vec3<double>(at[0] * x + at[1] * y), at.norm());
        CHECK((surface.position(path.back()) - surface.position(to)).norm() < 1e-9 * at.norm());
      }
    }
  }
}

TEST_CASE("equal angles at a cone's tip and at a saddle") {
  // Fans of n faces of one angle: from the middle of a face through the centre, it leaves where
  // both sides are equal.
  for (const Index n : {5, 6, 7, 9}) {
    Mesh<double> mesh;
    mesh.positions.push_back({0, 0, 0});
    for (Index k = 0; k < n; ++k) {
      // Any heights with equal angles between neighbours would do; for n > 6 they go up and down.
      const double a = 2 * pi * k / n;
      const double lift =
          n <= 6 ? std::sqrt(std::max(0.0, 1 - std::pow(0.5 / std::sin(pi / n), 2))) : 0;
      const double r = n <= 6 ? 0.5 / std::sin(pi / n) : 1;
      mesh.positions.push_back(
          {r * std::cos(a), r * std::sin(a), n <= 6 ? lift : 0.3 * std::cos(2 * a)});
      mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % n});
    }
    const Surface<double> surface(mesh);
    double total = 0;
    const auto angle_at = [&](Index k) {
      const auto a = surface.position(1 + k), b = surface.position(1 + (k + 1) % n);
      return std::atan2(cross<double>(a, b).norm(), a.dot(b));
    };
    for (Index k = 0; k < n; ++k) total += angle_at(k);
    const auto from = face_point<double>(0, {0.4, 0.35, 0.25});
    const Vec3<double> p = surface.position(from);
    const auto path = trace_geodesic(surface, from, Vec3<double>(-p), p.norm() + 0.2);
    const Vec3<double> end = surface.position(path.back());
    CHECK(end.norm() == gelight::test::approx(0.2).epsilon(1e-9));
    // The angle from p to the end, counted through faces 0, 1, 2 and so on.
    const auto a0 = surface.position(2);
    double sum = std::atan2(cross<double>(p, a0).norm(), p.dot(a0));
    REQUIRE(path.back().kind != SurfacePoint<double>::Kind::vertex);
    for (Index k = 1; k < n; ++k) {
      const auto a = surface.position(1 + k);
      const double within = std::atan2(cross<double>(a, end).norm(), a.dot(end));
      const auto b = surface.position(1 + (k + 1) % n);
      const double rest = std::atan2(cross<double>(b, end).norm(), b.dot(end));
      if (std::abs(within + rest - angle_at(k)) < 1e-9) {
        CHECK(sum + within == gelight::test::approx(total / 2).epsilon(1e-8));
        break;
      }
      sum += angle_at(k);
      CHECK(k + 1 < n);
    }
  }
}

TEST_CASE("great circles of a fine sphere; a cylinder's helix; float") {
  const auto mesh = icosphere<float>(5);
  const Surface<float> surface(mesh);
  const auto p = surface.position(100);
  const Vec3<float> d = detail::unit_orthogonal<float>(p);
  const auto path = trace_geodesic(surface, vertex_point<float>(100), d, 3.0F);
  const Vec3<float> q = surface.position(path.back());
  CHECK((q - (std::cos(3.0F) * p + std::sin(3.0F) * d)).norm() < 0.02F);
  CHECK(length(surface, path) == gelight::test::approx(3).epsilon(1e-5));

  // An unrolled prism: x is the way round.
  constexpr Index around = 24;
  Mesh<double> tube;
  for (Index i = 0; i <= 40; ++i) {
    for (Index j = 0; j < around; ++j) {
      const double a = 2 * pi * j / around;
      tube.positions.push_back({std::cos(a), std::sin(a), i * 0.25});
      const Index v = i * around + j, w = i * around + (j + 1) % around;
      if (i < 40) {
        tube.faces.push_back({v, w, v + around});
        tube.faces.push_back({w, w + around, v + around});
      }
    }
  }
  const Surface<double> side(tube);
  const double circle = around * 2 * std::sin(pi / around);
  const auto start = face_point<double>(2 * around, {0.3, 0.4, 0.3});
  const Vec3<double> first = side.position(start);
  const double rise = 0.01, run = 20 * circle;
  const Vec3<double> round = detail::stable_unit(side.position(around + 1) - side.position(around));
  const Vec3<double> up(0, 0, 1);
  const auto helix =
      trace_geodesic(side, start, Vec3<double>(round + rise * up), std::hypot(run, rise * run));
  const Vec3<double> above = first + rise * run * up;
  CHECK((side.position(helix.back()) - above).norm() < 1e-10);
  check_pieces(side, trace_geodesic(side, start, Vec3<double>(round + 0.5 * up), 6.0));
}

TEST_CASE("edges of no length are points; three faces on an edge end it") {
  // A sheet split along a line of which one edge has both ends at one place.
  Mesh<double> mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 0}, {0, 0, 0}};
  mesh.faces = {{0, 1, 4}, {1, 5, 4}, {1, 2, 5}, {2, 3, 5}, {3, 4, 5}, {3, 0, 4}};
  const Surface<double> surface(mesh);
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    const double a = test::uniform(random, -pi, pi);
    const Vec3<double> d(std::cos(a), std::sin(a), 0);
    for (const double off : {0.0, 1e-3}) {
      const Vec3<double> start = -0.4 * d + off * Vec3<double>(-d[1], d[0], 0);
      const auto from = nearest_point(surface, start);
      const auto path = trace_geodesic(surface, from, d, 0.8);
      CHECK((surface.position(path.back()) - start - 0.8 * d).norm() < 1e-9);
    }
  }
  Mesh<double> book;
  book.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}};
  book.faces = {{0, 2, 1}, {0, 1, 3}, {0, 1, 4}};
  const Surface<double> pages(book);
  const auto path =
      trace_geodesic(pages, face_point<double>(0, {0.3, 0.4, 0.3}), Vec3<double>(-1, 0, 0), 5.0);
  CHECK(path.back().kind == SurfacePoint<double>::Kind::edge);
  CHECK(path.size() == 2);
}

namespace {

// A face of a mesh, at random.
std::array<Index, 3>& some_face(Mesh<double>& mesh, Random& random) {
  const auto count = static_cast<Index>(mesh.faces.size());
  return mesh.faces[static_cast<std::size_t>(test::uniform_index(random, count))];
}
std::array<double, 3>& place(Mesh<double>& mesh, Index v) {
  return mesh.positions[static_cast<std::size_t>(v)];
}

// Any mesh, and what is in the way of a straight line: edges of no length, or next to none, caps
// of no area under an edge; of any size and at any distance from the origin.
Mesh<double> awkward_mesh(int kind, Random& random) {
  Mesh<double> mesh = test::small_random_mesh(kind, random);
  for (Index i = test::uniform_index(random, 3); i > 0; --i) {
    const auto face = some_face(mesh, random);
    place(mesh, face[0]) = place(mesh, face[1]);
    const double off = std::pow(10, test::uniform(random, -20, -3));
    if (i == 2) place(mesh, face[0])[0] += off;
  }
  for (Index i = test::uniform_index(random, 3); i > 0; --i) {
    const auto face = some_face(mesh, random);
    const double t = test::uniform(random, 0, 1);
    std::array<double, 3> p{};
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = (1 - t) * place(mesh, face[0])[c] + t * place(mesh, face[1])[c];
    }
    mesh.positions.push_back(p);
    mesh.faces.push_back({face[0], face[1], static_cast<Index>(mesh.positions.size()) - 1});
  }
  const double scale = std::pow(10, test::uniform(random, -6, 6));
  const double offset = kind % 3 == 0 ? std::pow(10, test::uniform(random, 0, 6)) : 0;
  for (auto& p : mesh.positions) {
    for (double& x : p) x = (x + offset) * scale;
  }
  return mesh;
}

// Whether a straight line may end at a point: at a border, at an edge of three faces, and at a
// vertex with such edges or with faces that are oriented against each other.
bool may_end_at(const Surface<double>& surface, const SurfacePoint<double>& p) {
  using Kind = SurfacePoint<double>::Kind;
  const auto is_plain = [&](Index h) {
    const Index t = surface.twin(h);
    return t != h && surface.is_manifold(h) && surface.origin(t) != surface.origin(h);
  };
  if (p.kind == Kind::face) return false;
  if (p.kind == Kind::edge) {
    const Index h = surface.find_halfedge(p.element[0], p.element[1]);
    if (surface.length(h) > 0) return surface.is_border(h) || !surface.is_manifold(h);
  }
  for (const Index h : surface.corners(p.element[0])) {
    for (const Index g : {h, surface.next(h), surface.previous(h)}) {
      if (!is_plain(g) || surface.length(g) < 1e-12 * surface.length(surface.next(g))) return true;
    }
  }
  return false;
}

}  // namespace

TEST_CASE("where edges have no length, faces no area and fans meet it is whole, or refused") {
  Random random(8);
  int whole = 0, refused = 0;
  for (int kind = 0; kind < 600; ++kind) {
    const auto mesh = awkward_mesh(kind, random);
    std::optional<Surface<double>> taken;
    if (test::refusal([&] { taken.emplace(mesh); }) != "accepted") continue;
    const Surface<double>& surface = *taken;
    for (int i = 0; i < 12; ++i) {
      const auto from = test::random_point(mesh, random);
      const Vec3<double> d(test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                           test::uniform(random, -1, 1));
      const double asked = detail::mean_edge_length(surface) * test::uniform(random, 0.1, 5);
      Path<double> path;
      const std::string words =
          test::refusal([&] { path = trace_geodesic(surface, from, d, asked); });
      if (words != "accepted") {
        const bool is_right = test::contains(words, "no area") ||
                              test::contains(words, "too little area") ||
                              test::contains(words, "is in the plane of none") ||
                              test::contains(words, "at a right angle");
        CHECK_MESSAGE(is_right, words);
        ++refused;
        continue;
      }
      for (const auto& p : path) {
        const std::string fault = test::refusal([&] { surface.require_point(p); });
        CHECK_MESSAGE(fault == "accepted", fault);
      }
      check_pieces(surface, path);
      const double got = length(surface, path);
      CHECK(got <= asked * (1 + 1e-6));
      const bool is_short = got < asked * (1 - 1e-6);
      CHECK_MESSAGE((!is_short || may_end_at(surface, path.back())), kind, ": ", got, " of ",
                    asked);
      whole += !is_short;
    }
  }
  CHECK(whole > 1000);
  CHECK(refused > 100);
}

TEST_CASE("from a point of an edge of no length to a vertex beside it each piece is in a face") {
  const Mesh<double> mesh{{{1, 1, 0}, {1, 1, 0}, {1, 1, 0}, {0, 0, 0}, {2, 0, 0}, {0, 3, 0}},
                          {{0, 1, 3}, {1, 2, 4}, {2, 4, 5}}};
  const Surface<double> surface(mesh);
  // Into the last face, which has neither of the edge's ends, only a vertex at their place.
  const Vec3<double> direction(0, 1, 0);
  const auto path = trace_geodesic(surface, edge_point<double>(0, 1, 0.4), direction, 0.25);
  check_pieces(surface, path);
  CHECK(length(surface, path) == doctest::Approx(0.25));
}

TEST_CASE("in float a path of a hundred thousand pieces is as long as was asked") {
  const Surface<float> ball(icosphere<float>(2));
  const auto from = face_point<float>(3, {0.2f, 0.3f, 0.5f});
  const auto path = trace_geodesic(ball, from, Vec3<float>(1, 0.3f, 0.2f), 20000.0f);
  CHECK(path.size() > 80000);
  CHECK(length(ball, path) == gelight::test::approx(20000).epsilon(1e-5));
}

TEST_CASE("a direction in a face's plane leads into it, however far from the origin") {
  Random random(9);
  for (const double offset : {0.0, 1e3, 1e6}) {
    for (int kind = 0; kind < 90; ++kind) {
      // With pages on some edges and caps of no area under others, at places of float's.
      Mesh<double> mesh = test::small_random_mesh(kind, random);
      const auto under = some_face(mesh, random);
      mesh.positions.push_back(place(mesh, under[0]));
      for (std::size_t c = 0; c < 3; ++c) {
        mesh.positions.back()[c] = (place(mesh, under[0])[c] + place(mesh, under[1])[c]) / 2;
      }
      mesh.faces.push_back({under[0], under[1], static_cast<Index>(mesh.positions.size()) - 1});
      for (auto& p : mesh.positions) {
        for (double& x : p) x += offset;
      }
      const Surface<double> surface(mesh);
      for (int i = 0; i < 10; ++i) {
        const Index f = test::uniform_index(random, surface.face_count() - 1);
        const auto [a, b, c] = surface.face(f);
        const Vec3<double> ab = surface.position(b) - surface.position(a);
        const Vec3<double> ac = surface.position(c) - surface.position(a);
        if (cross(ab, ac).norm() < 1e-2 * std::max(ab.squaredNorm(), ac.squaredNorm())) continue;
        const auto to = face_point<double>(f, {0.2, 0.4 + test::uniform(random, -0.2, 0.2), 0});
        auto end = to;
        end.weights[2] = 1 - end.weights[0] - end.weights[1];
        for (const auto& from : {vertex_point<double>(a), edge_point(a, b, 0.3)}) {
          // As whoever has places of points only would have it.
          const Vec3<double> way = surface.position(end) - surface.position(from);
          const auto path = trace_geodesic(surface, from, way, way.norm());
          CHECK(path.size() == 2);
          CHECK(surface.difference(path.back(), end).norm() <= 1e-8 * way.norm() + 1e-14 * offset);
        }
      }
    }
  }
}

TEST_CASE("bad input and cancelling") {
  const Surface<double> surface(icosphere<double>(2));
  const auto p = face_point<double>(3, {0.2, 0.3, 0.5});
  const Vec3<double> d(1, 0.3, 0.2);
  CHECK_THROWS_AS((void)trace_geodesic(surface, p, Vec3<double>(0, 0, 0), 1.0), InvalidInput);
  CHECK_THROWS_AS((void)trace_geodesic(surface, p, d, -1.0), InvalidInput);
  CHECK_THROWS_AS((void)trace_geodesic(surface, p, d, std::numeric_limits<double>::infinity()),
                  InvalidInput);
  CHECK_THROWS_AS((void)trace_geodesic(surface, p, Vec3<double>(std::nan(""), 0, 0), 1.0),
                  InvalidInput);
  CHECK_THROWS_AS((void)trace_geodesic(surface, face_point<double>(3, {0.2, 0.3, 0.6}), d, 1.0),
                  InvalidInput);
  CHECK(trace_geodesic(surface, p, d, 0.0) == Path<double>{p});
  int asked = 0;
  const CancelHook stop([&asked] { return ++asked > 3; });
  CHECK_THROWS_AS((void)trace_geodesic(surface, p, d, 1e6, stop), Cancelled);
}

TEST_CASE("on a mesh of floats a direction of doubles may have any length") {
  const auto mesh = icosphere<float>(2);
  const auto p = face_point<double>(3, {0.2, 0.3, 0.5});
  const Vec3<double> d(1, 0.3, 0.2);
  const auto path = trace_geodesic(mesh, p, d, 1.0);
  for (const double scale : {1e-300, 1e-60, 1e60, 1e300}) {
    CAPTURE(scale);
    const auto scaled = trace_geodesic(mesh, p, Vec3<double>(scale * d), 1.0);
    REQUIRE(scaled.size() == path.size());
    CHECK(scaled.back().element == path.back().element);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::abs(scaled.back().weights[k] - path.back().weights[k]) < 1e-5);
    }
  }
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k < 3; ++k) {
    for (const double wrong : {nan, std::numeric_limits<double>::infinity()}) {
      Vec3<double> odd = d;
      odd[k] = wrong;
      CHECK_THROWS_AS((void)trace_geodesic(mesh, p, odd, 1.0), InvalidInput);
    }
  }
  CHECK_THROWS_AS((void)trace_geodesic(mesh, p, Vec3<double>(0, 0, 0), 1.0), InvalidInput);
  const std::string refusal = test::refusal([&] { (void)trace_geodesic(mesh, p, d, 1e60); });
  CHECK(test::contains(refusal, "is beyond the numbers of the mesh"));
}

TEST_CASE("along edges, round an octahedron many times") {
  Mesh<double> mesh;
  mesh.positions = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  const Surface<double> surface(mesh);
  constexpr std::size_t edges = 200000;
  const double far = (edges + 0.5) * std::sqrt(2.0);
  const auto path = trace_geodesic(surface, vertex_point<double>(0), Vec3<double>(-1, 1, 0), far);
  REQUIRE(path.size() == edges + 2);
  for (std::size_t i = 0; i <= edges; i += 997) {
    CHECK(path[i] == vertex_point<double>(static_cast<Index>(i % 4)));
  }
  CHECK(length(surface, path) == gelight::test::approx(far).epsilon(1e-9));
}
