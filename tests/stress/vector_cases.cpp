#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "stress/query.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"

// Rows 36 to 39: vectors and light.

namespace gelight::stress {

namespace {

// Calls `act(mesh in the precision, rounding of the precision)`.
void in(Precision precision, const Mesh<double>& mesh, auto&& act) {
  if (precision == Precision::in_float) {
    act(cast<float>(mesh), 1e-5);
  } else {
    act(mesh, 1e-11);
  }
}

double angle_between(const auto& a, const auto& b) {
  const Vec3<double> p = a.template cast<double>(), q = b.template cast<double>();
  return std::atan2(cross<double>(p, q).norm(), p.dot(q));
}

void holonomy(Findings& findings, Precision precision) {
  const std::vector<double> radii{1, 2};
  for (const double angle : {1.0, 3.0, 5.0, 7.0}) {
    const auto mesh = test::cone(angle, 16, radii);
    in(precision, mesh, [&](const auto& own, double rounding) {
      const Surface<double> surface(own);
      const TangentFrames<double> frames(surface);
      std::complex<double> round = 1;
      for (Index j = 0; j < 16; ++j) {
        const Index h = surface.find_halfedge(1 + j, 1 + (j + 1) % 16);
        const bool same_way = surface.origin(h) == 1 + j;
        round *= same_way ? frames.transport(h) : std::conj(frames.transport(h));
      }
      findings.expect(std::abs(round - std::polar(1.0, 2 * pi - angle)) < rounding,
                      "round a cone of angle " + std::to_string(angle) + " a vector turns by " +
                          std::to_string(std::arg(round)));
    });
  }
  // Round an octant of the sphere: along the equator, up to the pole, and down again.
  const auto mesh = icosphere<double>(4);
  const Surface<double> surface(mesh);
  in(precision, mesh, [&](const auto& own, double) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const VectorHeatSolver<T> solver(own);
    const auto nearest = [&](double x, double y, double z) {
      return nearest_vertex<double>(surface, Vec3<double>(x, y, z));
    };
    const std::array<Index, 3> corners{nearest(1, 0, 0), nearest(0, 1, 0), nearest(0, 0, 1)};
    Vec3<T> carried(0, 0, 1);
    const auto start = solver.tangent_basis(corners[0]);
    Vec3<T> first = carried.dot(start[0]) * start[0] + carried.dot(start[1]) * start[1];
    carried = first;
    for (std::size_t k = 0; k < 3; ++k) {
      carried =
          solver.transport(corners[k], carried)[static_cast<std::size_t>(corners[(k + 1) % 3])];
    }
    // The corners are vertices near the octant's, off by up to half an edge of 4 degrees.
    const double turn = angle_between(first, carried);
    findings.expect(std::fabs(turn - pi / 2) < 0.15,
                    "round an octant a vector turns by " + std::to_string(turn));
  });
}

void log_maps(Findings& findings, Precision precision) {
  test::Random random(37);
  const auto mesh = test::jittered_grid(16, 0.2, random);
  const Index source = 17 * 5 + 6;
  in(precision, mesh, [&](const auto& own, double) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const VectorHeatSolver<T> solver(own);
    const auto map = solver.log_map(source);
    const auto basis = solver.tangent_basis(source);
    const auto distance = HeatSolver<T>(own).distance(source);
    double off = 0;
    for (std::size_t v = 0; v < map.size(); ++v) {
      const Vec3<T> way = map[v][0] * basis[0] + map[v][1] * basis[1];
      const auto& p = mesh.positions[v];
      const auto& s = mesh.position(source);
      const Vec3<double> truth(p[0] - s[0], p[1] - s[1], 0);
      off = std::max(off, (way.template cast<double>() - truth).norm());
      findings.expect(std::isfinite(map[v].norm()), "a coordinate that is not finite");
      if (truth.norm() < 3) continue;  // neighbours are set exactly, not by the heat's distance
      findings.expect(std::fabs(double{map[v].norm()} - double{distance[v]}) < 1e-4,
                      "the radius is not the distance");
    }
    findings.expect(off < 2.5, "on a flat sheet " + std::to_string(off) + " cells off");
    findings.expect(map[static_cast<std::size_t>(source)].norm() == 0, "not zero at the source");
  });
}

// At an antipode, and behind a cylinder, several straight lines arrive; none is their average.
void cut_locus(Findings& findings, Precision precision) {
  const Index sides = 16, rings = 9;
  Mesh<double> prism;
  for (Index k = 0; k < rings; ++k) {
    for (Index j = 0; j < sides; ++j) {
      const double turn = 2 * pi * j / sides;
      prism.positions.push_back({std::cos(turn), std::sin(turn), 0.4 * k});
      if (k == 0) continue;
      const Index a = sides * (k - 1) + j, b = sides * (k - 1) + (j + 1) % sides;
      prism.faces.push_back({a, b, b + sides});
      prism.faces.push_back({a, b + sides, a + sides});
    }
  }
  const Index source = sides * 4, opposite = sides * 4 + sides / 2;
  in(precision, prism, [&](const auto& own, double rounding) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const ExactSolver<T> solver(own);
    const auto field = solver.solve(source);
    const auto arrivals = field.arrivals(opposite, static_cast<T>(rounding));
    findings.expect(arrivals.size() == 2,
                    std::to_string(arrivals.size()) + " arrivals behind the cylinder, of 2");
    const auto direction = field.direction(opposite);
    bool is_one = false;
    for (const auto& arrival : arrivals)
      is_one |= angle_between(arrival.direction, direction) < 1e-3;
    findings.expect(is_one, "the direction behind the cylinder is none of the arrivals");
    const VectorHeatSolver<T> vectors(own);
    for (const auto& v : vectors.radial(source)) {
      const double length = v.norm();
      findings.expect(std::isfinite(length) && (length == 0 || std::fabs(length - 1) < 1e-4),
                      "a radial direction of length " + std::to_string(length));
    }
  });
  const auto sphere = icosphere<double>(3);
  in(precision, sphere, [&](const auto& own, double) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const auto field = ExactSolver<T>(own).solve(Index{0});
    const Surface<double> surface(own);
    const Index antipode = nearest_vertex<double>(surface, -surface.position(0));
    const auto arrivals = field.arrivals(antipode, T(1e-5));
    findings.expect(arrivals.size() >= 5,
                    std::to_string(arrivals.size()) + " arrivals at the antipode, of 5");
  });
}

void quadrants(Findings& findings, Precision precision) {
  test::Random random(39);
  const auto mesh = test::jittered_grid(9, 0.2, random);
  in(precision, mesh, [&](const auto& own, double rounding) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const VectorHeatSolver<T> solver(own);
    for (const auto& [x, y] : {std::array{2.0, 1.0},
                               {-2.0, 1.0},
                               {-2.0, -1.0},
                               {2.0, -1.0},
                               {1.0, 0.0},
                               {-1.0, 0.0},
                               {0.0, 1.0},
                               {0.0, -1.0}}) {
      const Vec3<T> vector(static_cast<T>(x), static_cast<T>(y), 0);
      for (const auto& carried : solver.transport(44, vector)) {
        findings.expect((carried - vector).norm() < 3 * rounding,
                        "a vector of another quadrant arrives");
      }
    }
  });
  // Turning the source vector turns the result; lengths stay.
  const auto sphere = icosphere<double>(2);
  in(precision, sphere, [&](const auto& own, double rounding) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const VectorHeatSolver<T> solver(own);
    const auto basis = solver.tangent_basis(7);
    const auto x = solver.transport(7, basis[0]), y = solver.transport(7, basis[1]);
    for (int k = 0; k < 8; ++k) {
      const T c = static_cast<T>(std::cos(k * pi / 4)), s = static_cast<T>(std::sin(k * pi / 4));
      const auto turned = solver.transport(7, Vec3<T>(c * basis[0] + s * basis[1]));
      for (std::size_t v = 0; v < turned.size(); ++v) {
        // At the antipode any direction is as good as another.
        if (gap(sphere.positions[v], sphere.positions[7]) > 1.99) continue;
        findings.expect((turned[v] - (c * x[v] + s * y[v])).norm() < rounding,
                        "turning the source does not turn the result");
        findings.expect(std::fabs(double{turned[v].norm()} - 1) < rounding, "the length changes");
      }
    }
  });
}

void says_no(Findings& findings, Precision precision) {
  auto mesh = icosphere<double>(1);
  const auto refused = [&](const std::string& part) {
    in(precision, mesh, [&](const auto& own, double) {
      findings.expect_refusal(part, [&] { VectorHeatSolver solver(own); });
    });
  };
  std::swap(mesh.faces[7][0], mesh.faces[7][1]);
  refused("vectors need an orientation");
  mesh = icosphere<double>(1);
  mesh.positions.push_back({2, 2, 2});
  mesh.faces.push_back({mesh.faces[0][0], mesh.faces[0][1], 42});
  refused("vectors need an oriented manifold");
  mesh = icosphere<double>(1);
  in(precision, mesh, [&](const auto& own, double) {
    using T = typename std::decay_t<decltype(own)>::Scalar;
    const VectorHeatSolver<T> solver(own);
    const T bad = std::numeric_limits<T>::quiet_NaN();
    findings.expect_refusal("not finite", [&] { (void)solver.transport(0, Vec3<T>(bad, 0, 0)); });
    findings.expect_refusal("no part tangent", [&] {
      const auto basis = solver.tangent_basis(0);
      (void)solver.transport(0, cross<T>(basis[0], basis[1]));
    });
    findings.expect_refusal("out of range", [&] { (void)solver.log_map(42); });
  });
}

}  // namespace

std::vector<Case> vector_cases() {
  std::vector<Case> cases;
  cases.push_back({"36",
                   "transport round a cone's apex, and round an octant",
                   "",
                   {},
                   "holonomy = angle defect to rounding; pi / 2 within an edge",
                   holonomy});
  cases.push_back({"37",
                   "log map of a flat sheet",
                   "",
                   {},
                   "within 2.5 cells of 16 of x - s; radius = distance; zero at the source",
                   log_maps});
  cases.push_back({"38",
                   "behind a cylinder, antipode of a sphere",
                   "",
                   {},
                   "exact tells every arrival and averages none; radial fields stay unit",
                   cut_locus});
  cases.push_back({"39",
                   "source vectors of all quadrants and along both axes",
                   "",
                   {},
                   "equivariant, length kept",
                   quadrants});
  cases.push_back({"vectors 22",
                   "flipped faces, three faces on an edge, vectors without tangent",
                   "",
                   {},
                   "VectorHeatSolver refuses by name",
                   says_no});
  return cases;
}

}  // namespace gelight::stress
