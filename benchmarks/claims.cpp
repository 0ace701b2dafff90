#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "../examples/support/plain_words.hpp"
#include "gelight/geodesic/backtrace.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/planning/method_models.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/smooth/curved_faces.hpp"
#include "gelight/geodesic/smooth/fans.hpp"
#include "gelight/geodesic/smooth/fitted_normals.hpp"
#include "gelight/geodesic/smooth/lifted_path.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/transport/log_map.hpp"
#include "gelight/transport/parallel.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/plan_requests.hpp"
#include "support/scan_meshes.hpp"
#include "support/smooth_surfaces.hpp"

// claims             prints how far every method is off, as benchmarks/results/claims.md
// claims --quick     the same on scan-like meshes of a quarter of the vertices, of fewer requests
// claims --fans      of that the fans alone
// claims --smooth    of that the smooth surface alone
// claims --planner   of that the planner alone
// claims --expected  of that what the planner expects
//
// What docstrings say of errors is what this prints.

namespace {

using namespace gelight;

/// Mean, 99th percentile and largest.
struct Spread {
  double mean = 0, p99 = 0, most = 0;
};

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  Spread spread;
  for (const double x : values) spread.mean += x / static_cast<double>(values.size());
  const auto at = values.begin() + std::ssize(values) * 99 / 100;
  std::nth_element(values.begin(), at, values.end());
  spread.p99 = *at;
  spread.most = *std::max_element(at, values.end());
  return spread;
}

std::string text(const Spread& spread) {
  std::string out;
  for (const double x : {spread.mean, spread.p99, spread.most}) {
    std::array<char, 32> number{};
    if (x >= 100) {
      std::snprintf(number.data(), number.size(), "%.0f", x);
    } else {
      std::snprintf(number.data(), number.size(), "%.2g", x < 1e-7 ? 0 : x);
    }
    out += (out.empty() ? "" : ", ") + std::string(number.data());
  }
  return out;
}

/// The figures of one number over meshes: each of them the median's, or the worst mesh's.
Spread median_of(const std::vector<Spread>& meshes) {
  const auto median = [&](auto member) {
    std::vector<double> values;
    for (const Spread& spread : meshes) values.push_back(spread.*member);
    std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
    return values[values.size() / 2];
  };
  return {median(&Spread::mean), median(&Spread::p99), median(&Spread::most)};
}
Spread worst_of(const std::vector<Spread>& meshes) {
  Spread worst;
  for (const Spread& spread : meshes) {
    worst = {std::max(worst.mean, spread.mean), std::max(worst.p99, spread.p99),
             std::max(worst.most, spread.most)};
  }
  return worst;
}

/// Four vertices, far apart by number.
std::vector<Index> sources_of(const Mesh<double>& mesh) {
  const auto count = static_cast<Index>(mesh.positions.size());
  return {count / 7, 3 * count / 7, count / 2, 6 * count / 7};
}

// --- distances -----------------------------------------------------------------------------------

using Answers = std::vector<std::vector<double>>;  // of each source

/// A mesh on which methods are judged, with true distances.
struct Judged {
  std::string name;
  Mesh<double> mesh;
  Answers truth{};
};

template <class Solver>
Answers answers_of(const Solver& solver, const Mesh<double>& mesh) {
  Answers answers;
  for (const Index source : sources_of(mesh)) answers.push_back(solver.distance(source));
  return answers;
}

Judged against_exact(std::string name, Mesh<double> mesh) {
  Judged judged{std::move(name), std::move(mesh)};
  judged.truth = answers_of(ExactSolver(judged.mesh), judged.mesh);
  return judged;
}

Judged against_great_circles(int level) {
  Judged judged{"icosphere " + std::to_string(level), icosphere<double>(level)};
  for (const Index source : sources_of(judged.mesh)) {
    const Vec3<double> s(judged.mesh.position(source).data());
    std::vector<double> distance;
    for (const auto& p : judged.mesh.positions) {
      const Vec3<double> q(p.data());
      // (Where products are fused, a vector's cross product with itself is not quite zero.)
      distance.push_back(q == s ? 0 : std::atan2(s.cross(q).norm(), s.dot(q)));
    }
    judged.truth.push_back(std::move(distance));
  }
  return judged;
}

struct Method {
  std::string name;
  std::function<Answers(const Mesh<double>&)> answers;
};

template <template <class> class Solver, class... Options>
Method method(std::string name, const Options&... options) {
  return {std::move(name), [=](const Mesh<double>& mesh) {
            return answers_of(Solver<double>(mesh, options...), mesh);
          }};
}

std::vector<Method> methods() {
  std::vector<Method> all{method<DijkstraSolver>("Dijkstra")};
  for (const Index points : {1, 2, 3, 5, 8}) {
    all.push_back(method<DijkstraSolver>("Dijkstra, Steiner points " + std::to_string(points),
                                         DijkstraOptions{.steiner_points = points}));
  }
  all.push_back(method<FastMarchingSolver>("fast marching"));
  all.push_back(method<VirtualSourceSolver>("virtual source"));
  for (const int radius : {1, 2, 4, 8, 16, 32}) {
    ExactOptions<double> options;
    options.reset_radius = radius;
    all.push_back(method<ExactSolver>("exact, reset radius " + std::to_string(radius), options));
  }
  all.push_back(method<ExactSolver>("exact"));
  for (const bool delaunay : {false, true}) {
    const std::string heat = delaunay ? "heat, intrinsic Delaunay" : "heat, the mesh as it is";
    all.push_back(method<HeatSolver>(heat, HeatOptions{.intrinsic_delaunay = delaunay}));
    all.push_back(
        method<HeatSolver>(heat + ", not exact beside the source",
                           HeatOptions{.exact_radius = 0, .intrinsic_delaunay = delaunay}));
    for (const Index times : {1, 2, 4}) {
      all.push_back(
          method<HeatSolver>(heat + ", refined " + std::to_string(times),
                             HeatOptions{.refinements = times, .intrinsic_delaunay = delaunay}));
    }
  }
  return all;
}

/// Relative errors in per cent.
Spread error_of(const Answers& answers, const Answers& truth) {
  std::vector<double> errors;
  for (std::size_t s = 0; s < truth.size(); ++s) {
    for (std::size_t v = 0; v < truth[s].size(); ++v) {
      if (!(truth[s][v] > 0) || std::isinf(truth[s][v])) continue;
      errors.push_back(100 * std::abs(answers[s][v] / truth[s][v] - 1));
    }
  }
  return spread_of(std::move(errors));
}

// --- vectors -------------------------------------------------------------------------------------

double degrees_between(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

struct VectorErrors {
  Spread transport, radial, log_direction, log_radius;
};

/// Of the vector heat method against parallel transport along exact paths, their directions and the
/// exact log map.
VectorErrors vector_errors(const Mesh<double>& mesh, bool delaunay) {
  const VectorHeatSolver<double> heat(mesh, {.intrinsic_delaunay = delaunay});
  const ExactLogMapSolver<double> exact(mesh);
  const ParallelTransport<double> parallel(mesh);
  std::vector<double> transport, radial, log_direction, log_radius;
  for (const Index source : sources_of(mesh)) {
    const auto truth = exact.solve(source);
    const Vec3<double> start = truth.tangent_basis()[0];
    const auto carried = heat.transport(source, start);
    const auto outward = heat.radial(source);
    const auto map = heat.log_map(source);
    for (Index v = 0; v < static_cast<Index>(mesh.positions.size()); ++v) {
      const auto i = static_cast<std::size_t>(v);
      const Vec2<double> wanted = truth(v);
      if (v == source || std::isinf(wanted[0]) || !(wanted.norm() > 0)) continue;
      transport.push_back(
          degrees_between(carried[i], parallel.along(truth.field().path(v), start)));
      const auto [x, y] = heat.tangent_basis(v);
      const Vec3<double> arrival = truth.field().direction(v);
      radial.push_back(degrees_between(outward[i], x * x.dot(arrival) + y * y.dot(arrival)));
      const std::complex<double> turn =
          std::complex<double>(map[i][0], map[i][1]) / std::complex<double>(wanted[0], wanted[1]);
      log_direction.push_back(std::abs(std::arg(turn)) * 180 / std::numbers::pi);
      log_radius.push_back(100 * std::abs(std::abs(turn) - 1));
    }
  }
  return {spread_of(transport), spread_of(radial), spread_of(log_direction), spread_of(log_radius)};
}

// --- tables --------------------------------------------------------------------------------------

struct Subjects {
  std::vector<Judged> singles;  // a column each
  std::vector<Judged> scans;    // of which the median and the worst are shown
};

void print_row(const std::vector<std::string>& cells) {
  for (const auto& cell : cells) std::printf("| %s ", cell.c_str());
  std::printf("|\n");
}

void print_head(const std::string& first, const Subjects& on) {
  std::vector<std::string> head{first}, rule{"---"};
  for (const Judged& judged : on.singles) head.push_back(judged.name);
  head.insert(head.end(), {"scans, median", "scans, worst", "worst in the mean on"});
  rule.resize(head.size(), "---");
  print_row(head);
  print_row(rule);
}

/// A row: what `error` finds on each mesh.
void print_errors(const std::string& name, const Subjects& on, const auto& error) {
  std::vector<std::string> cells{name};
  for (const Judged& judged : on.singles) cells.push_back(text(error(judged)));
  std::vector<Spread> scans;
  for (const Judged& judged : on.scans) scans.push_back(error(judged));
  const auto worst = std::max_element(
      scans.begin(), scans.end(), [](const Spread& a, const Spread& b) { return a.mean < b.mean; });
  cells.push_back(text(median_of(scans)));
  cells.push_back(text(worst_of(scans)));
  cells.push_back(worst->mean < 1e-7 ? "" : on.scans[std::size_t(worst - scans.begin())].name);
  print_row(cells);
}

void print_distances(const Subjects& on) {
  print_head("distance", on);
  for (const Method& one : methods()) {
    print_errors(one.name, on, [&](const Judged& judged) {
      return error_of(one.answers(judged.mesh), judged.truth);
    });
  }
}

void print_refinements(const Subjects& on) {
  for (const bool delaunay : {false, true}) {
    std::printf("\nOf these %zu meshes, heat on ", on.scans.size());
    std::printf(delaunay ? "intrinsic Delaunay triangles" : "the mesh's own triangles");
    std::printf(" has a larger mean error after refining");
    const auto mean = [&](const Judged& judged, Index times) {
      const HeatSolver<double> solver(judged.mesh,
                                      {.refinements = times, .intrinsic_delaunay = delaunay});
      return error_of(answers_of(solver, judged.mesh), judged.truth).mean;
    };
    for (const Index times : {1, 2, 4}) {
      const auto worse = std::count_if(on.scans.begin(), on.scans.end(), [&](const Judged& judged) {
        return mean(judged, times) > mean(judged, 0);
      });
      std::printf("%s %d: on %d", times > 1 ? "," : "", times, static_cast<int>(worse));
    }
    std::printf(".\n");
  }
}

void print_vectors(const Subjects& on) {
  for (const bool delaunay : {false, true}) {
    std::vector<std::pair<const Judged*, VectorErrors>> found;
    for (const auto* list : {&on.singles, &on.scans}) {
      for (const Judged& judged : *list)
        found.emplace_back(&judged, vector_errors(judged.mesh, delaunay));
    }
    const auto row = [&](const std::string& name, Spread VectorErrors::*member) {
      print_errors(name + (delaunay ? ", intrinsic Delaunay" : ", the mesh as it is"), on,
                   [&](const Judged& judged) {
                     return std::find_if(found.begin(), found.end(),
                                         [&](const auto& entry) { return entry.first == &judged; })
                                ->second.*
                            member;
                   });
    };
    row("transport, degrees", &VectorErrors::transport);
    row("radial field, degrees", &VectorErrors::radial);
    row("log map's direction, degrees", &VectorErrors::log_direction);
    row("log map's radius, per cent", &VectorErrors::log_radius);
  }
}

// --- fans ----------------------------------------------------------------------------------------

/// A flat sheet of spokes round vertex 0, whose ends lie unevenly far out, in rings.
Mesh<double> uneven_fan(Index spokes, Index rings, test::Random& random) {
  Mesh<double> fan{{{0, 0, 0}}, {}};
  const auto vertex = [&](Index ring, Index spoke) { return 1 + spokes * ring + spoke % spokes; };
  for (Index ring = 0; ring < rings; ++ring) {
    for (Index k = 0; k < spokes; ++k) {
      const double a = 2 * std::numbers::pi * k / spokes;
      const double r = ring + test::uniform(random, 0.1, 1);
      fan.positions.push_back({r * std::cos(a), r * std::sin(a), 0});
      const Index out = vertex(ring, k), beside = vertex(ring, k + 1);
      if (ring == 0) {
        fan.faces.push_back({0, out, beside});
      } else {
        const Index in = vertex(ring - 1, k), in_beside = vertex(ring - 1, k + 1);
        fan.faces.insert(fan.faces.end(), {{in, out, beside}, {in, beside, in_beside}});
      }
    }
  }
  return fan;
}

/// Mean and largest error over the vertices, of the worst in either of 80 fields: four sources on
/// each of 20 fans of 5 to 64 spokes, in per cent.
template <template <class> class Solver>
std::string worst_on_fans(Index rings, double stretch) {
  test::Random random(1);
  Spread worst;
  for (int i = 0; i < 20; ++i) {
    const Index spokes = 5 + test::uniform_index(random, 60);
    const Mesh<double> fan = test::scans::stretched(uneven_fan(spokes, rings, random), stretch);
    const Solver<double> solver(fan);
    const ExactSolver<double> exact(fan);
    for (const Index source : sources_of(fan)) {
      const Spread one = error_of({solver.distance(source)}, {exact.distance(source)});
      worst = {std::max(worst.mean, one.mean), 0, std::max(worst.most, one.most)};
    }
  }
  std::array<char, 48> words{};
  std::snprintf(words.data(), words.size(), "%.2g, %.3g", worst.mean, worst.most);
  return words.data();
}

void print_fans() {
  std::printf(
      "\n## Flat fans whose ends lie unevenly\n\n"
      "Mean and largest error over the vertices in per cent, each of the worst of 80 fields: from "
      "four vertices of\neach of 20 fans of 5 to 64 spokes, their ends at random from 0.1 to 1 of "
      "a "
      "ring's width, stretched along x.\n\n");
  print_row({"fans", "fast marching", "virtual source"});
  print_row({"---", "---", "---"});
  for (const Index rings : {1, 2}) {
    for (const int stretch : {1, 10, 1000}) {
      print_row({std::to_string(rings) + (rings > 1 ? " rings" : " ring") + ", stretched " +
                     std::to_string(stretch),
                 worst_on_fans<FastMarchingSolver>(rings, stretch),
                 worst_on_fans<VirtualSourceSolver>(rings, stretch)});
    }
  }
}

// --- the smooth surface --------------------------------------------------------------------------

/// The mesh of a smooth solver with each face split in four, new vertices on the smooth surface.
Mesh<double> split(const Mesh<double>& mesh, const SmoothDistanceSolver<double>& smooth) {
  Mesh<double> out{mesh.positions, {}};
  std::map<std::pair<Index, Index>, Index> middles;
  const auto middle = [&](Index a, Index b) {
    const auto [at, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<Index>(out.positions.size()));
    if (is_new) {
      const Vec3<double> p = smooth.position(edge_point(a, b, 0.5));
      out.positions.push_back({p[0], p[1], p[2]});
    }
    return at->second;
  };
  for (const auto& [a, b, c] : mesh.faces) {
    const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    out.faces.insert(out.faces.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return out;
}

std::string error_on_smooth(const std::vector<double>& distance, const std::vector<double>& truth) {
  std::array<char, 16> words{};
  std::snprintf(words.data(), words.size(), "%.1e", test::mean_error(distance, truth));
  return words.data();
}

/// Approximate distances from vertex 0 with the lengths, on the smooth surface, of the paths to
/// which they lead; where those are rough, as they are.
std::vector<double> lifted(const Mesh<double>& mesh, std::vector<double> distance) {
  const Surface<double> surface(mesh);
  const SmoothOptions<double> options;
  const detail::Fans<double> fans(surface, options.crease_angle, {});
  detail::FittedNormals<double> fitted(fans);
  detail::Array<Vec3<double>> normals;
  for (Index fan = 0; fan < fans.count(); ++fan) normals.push_back(fitted.normal(fan));
  const detail::CurvedFaces<double> faces(fans, normals);
  detail::LiftedPath<double> lift(faces);
  const auto source = vertex_point<double>(0);
  detail::Backtrace<double> back(surface, {{source, 0}}, distance, true);
  for (Index v = 1; v < surface.vertex_count(); ++v) {
    if (!back.walk(v).has_arrived) continue;
    Path<double> path = back.path();
    if (path.back() != source) path.push_back(source);
    std::reverse(path.begin(), path.end());
    const auto found = lift.measure(path);
    if (!(found.roughness <= options.most_roughness)) continue;
    distance[static_cast<std::size_t>(v)] = found.shortest();
  }
  return distance;
}

struct OnSmooth {
  std::string name;
  Mesh<double> mesh;
  std::vector<double> truth;
};

std::vector<OnSmooth> smooth_subjects() {
  test::Random random(5);
  std::vector<OnSmooth> all;
  for (const auto& [name, height] : {std::pair{"sphere", 1.0}, std::pair{"spheroid 1 : 0.5", 0.5},
                                     std::pair{"spheroid 1 : 3", 3.0}}) {
    for (const int level : {4, 5}) {
      auto c = test::spheroid(level, height, 0.2, random);
      all.push_back({name, std::move(c.mesh), std::move(c.truth)});
    }
  }
  const auto torus = test::jittered_torus(144, 72, 0.25, random);
  all.push_back(
      {"torus", torus.mesh, test::torus_distances(torus, ExactSolver(torus.mesh).solve(0), 23)});
  for (const auto& [name, noise] :
       {std::pair{"sphere, noise 0.01", 0.01}, std::pair{"sphere, noise 0.1", 0.1}}) {
    auto c = test::spheroid(5, 1, 0.2, random);
    all.push_back({name, test::scans::noisy(c.mesh, noise, random), std::move(c.truth)});
  }
  return all;
}

/// Mean errors on the mesh, on the split one, and extrapolated from both.
template <template <class> class Solver>
void add_bases(std::vector<std::string>& row, const OnSmooth& on, const Mesh<double>& fine) {
  const auto coarse = Solver<double>(on.mesh).distance(0);
  const auto finer = Solver<double>(fine).distance(0);
  auto extrapolated = coarse;
  for (std::size_t v = 0; v < coarse.size(); ++v) {
    extrapolated[v] = (4 * finer[v] - coarse[v]) / 3;
  }
  for (const auto& distance : {coarse, finer, extrapolated}) {
    row.push_back(error_on_smooth(distance, on.truth));
  }
}

void print_smooth() {
  std::printf(
      "\n## The smooth surface, from other distances than exact ones\n\n"
      "Mean relative errors from one vertex against the smooth surface's distances, on meshes "
      "whose vertices are\nmoved on it by up to a fifth of an edge (torus: a quarter of a cell). "
      "Split: on the mesh with each face split\nonce in four, new vertices on the surface of the "
      "fitted normals. Extrapolated: (4 split - mesh) / 3. Lifted:\nlengths of the paths to which "
      "the distances lead, as SmoothDistanceSolver has those of its exact paths.\n\n");
  std::vector<std::string> head{"mesh", "vertices"};
  for (const std::string base : {"exact", "fast marching", "virtual source"}) {
    head.insert(head.end(), {base, base + ", split", base + ", extrapolated", base + ", lifted"});
  }
  print_row(head);
  print_row(std::vector<std::string>(head.size(), "---"));
  for (const OnSmooth& on : smooth_subjects()) {
    const SmoothDistanceSolver<double> smooth(on.mesh);
    const Mesh<double> fine = split(on.mesh, smooth);
    std::vector<std::string> row{on.name, std::to_string(on.mesh.positions.size())};
    add_bases<ExactSolver>(row, on, fine);
    row.push_back(error_on_smooth(smooth.distance(0), on.truth));
    add_bases<FastMarchingSolver>(row, on, fine);
    row.push_back(error_on_smooth(lifted(on.mesh, FastMarchingSolver<double>(on.mesh).distance(0)),
                                  on.truth));
    add_bases<VirtualSourceSolver>(row, on, fine);
    row.push_back(error_on_smooth(lifted(on.mesh, VirtualSourceSolver<double>(on.mesh).distance(0)),
                                  on.truth));
    print_row(row);
  }
}

// --- the planner ---------------------------------------------------------------------------------

/// Of the answers that say of themselves that they satisfy a request.
struct Promises {
  int kept = 0, broken = 0, approximate = 0;
};

template <std::floating_point T>
void judge(std::uint64_t number, std::array<Promises, 3>& by_assurance) {
  const auto asked = test::random_request(number);
  const auto verdict = test::answered<T>(asked);
  if (!verdict.answer.satisfies) return;
  Promises& promises = by_assurance[static_cast<std::size_t>(verdict.answer.achieved)];
  const bool is_kept = verdict.error <= asked.request.tolerance;
  ++(is_kept ? promises.kept : promises.broken);
  promises.approximate += verdict.answer.method != "exact";
}

void print_planner(int requests) {
  std::array<Promises, 3> promises;
  for (int i = 0; i < requests; ++i) {
    const auto number = 1'000'000'000 + static_cast<std::uint64_t>(i);
    if (i % 2 == 0) {
      judge<double>(number, promises);
    } else {
      judge<float>(number, promises);
    }
  }
  std::printf(
      "\n## What DistancePlanner promises\n\n"
      "Answers that say they satisfy their request, of %d requests at random "
      "(tests/support/plan_requests.hpp),\nhalf of them in float, against ExactSolver<double>.\n\n",
      requests);
  print_row({"achieved", "kept", "not kept", "of all by an approximation"});
  print_row({"---", "---", "---", "---"});
  for (const auto& [name, assurance] :
       {std::pair{"certified", Assurance::certified}, std::pair{"sampled", Assurance::sampled},
        std::pair{"expected", Assurance::expected}}) {
    const Promises& of = promises[static_cast<std::size_t>(assurance)];
    print_row(
        {name, std::to_string(of.kept), std::to_string(of.broken), std::to_string(of.approximate)});
  }
}

/// Of one method's fields: how far its errors are beyond what the planner expects of them.
struct Expectation {
  std::vector<double> mean, largest;  // errors as shares of the expected ones
};

/// The share of numbers beyond 1, and the one that 98 in 100 keep.
std::array<std::string, 2> beyond_and_most(std::vector<double> shares) {
  std::sort(shares.begin(), shares.end());
  const auto kept = std::upper_bound(shares.begin(), shares.end(), 1.0) - shares.begin();
  const auto count = static_cast<double>(shares.size());
  const double beyond = 1 - static_cast<double>(kept) / count;
  return {detail::two_digits(100 * beyond) + " %",
          detail::two_digits(shares[static_cast<std::size_t>(0.98 * (count - 1))])};
}

/// What the planner expects of methods on the meshes that it calls familiar, from one source each.
void print_expected(int meshes) {
  constexpr std::array methods{detail::Method::dijkstra, detail::Method::virtual_source,
                               detail::Method::fast_marching};
  std::array<Expectation, methods.size()> found;
  int fields = 0;
  for (int i = 0; i < meshes; ++i) {
    test::Random random(2'000'000'000 + static_cast<std::uint64_t>(i));
    const auto mesh = test::requests::mesh_of(i % test::requests::kinds, random);
    if (mesh.faces.empty() || !check(mesh).is_accepted()) continue;
    const Surface<double> surface(mesh);
    const detail::MeshStatistics<double> statistics(surface);
    const detail::MethodErrors<double> errors(statistics);
    if (surface.vertex_count() > 2600 || *errors.unfamiliar() != '\0') continue;
    const Index source = test::uniform_index(random, surface.vertex_count());
    const auto truth = ExactSolver<double>(surface).distance(source);
    const std::array answers{DijkstraSolver<double>(surface).distance(source),
                             VirtualSourceSolver<double>(surface).distance(source),
                             FastMarchingSolver<double>(surface).distance(source)};
    for (std::size_t m = 0; m < methods.size(); ++m) {
      PlanRequest in_norm;
      const auto expected = errors.of(methods[m]);
      in_norm.norm = ErrorNorm::mean;
      found[m].mean.push_back(test::true_error(answers[m], 0, truth, in_norm) / expected.mean);
      in_norm.norm = ErrorNorm::max;
      found[m].largest.push_back(test::true_error(answers[m], 0, truth, in_norm) / expected.max);
    }
    ++fields;
  }
  std::printf(
      "\n## What DistancePlanner expects of methods\n\n"
      "Errors as shares of those of detail::MethodErrors, of %d fields from one source on familiar "
      "meshes at random\n(tests/support/plan_requests.hpp, %d kinds, 100 to 2,600 vertices), "
      "against ExactSolver.\n\n",
      fields, int{test::requests::kinds});
  print_row({"method", "mean beyond it", "98 in 100 keep", "most", "largest beyond it",
             "98 in 100 keep", "most"});
  print_row({"---", "---", "---", "---", "---", "---", "---"});
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::vector<std::string> row{detail::name_of(methods[m])};
    for (const auto* shares : {&found[m].mean, &found[m].largest}) {
      for (auto& cell : beyond_and_most(*shares)) row.push_back(std::move(cell));
      row.push_back(detail::two_digits(*std::max_element(shares->begin(), shares->end())));
    }
    print_row(row);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string only = argc > 1 ? argv[1] : "";
  const bool is_quick = only == "--quick";
  const int requests = is_quick ? 300 : 3000;
  if (only == "--fans") return print_fans(), 0;
  if (only == "--smooth") return print_smooth(), 0;
  if (only == "--planner") return print_planner(requests), 0;
  if (only == "--expected") return print_expected(2 * requests), 0;
  if (argc > 2 || (argc == 2 && !is_quick)) {
    throw std::runtime_error(
        "usage: claims [--quick | --fans | --smooth | --planner | --expected]");
  }
  Subjects on;
  for (const int level : {4, 5}) on.singles.push_back(against_great_circles(level));
  on.singles.push_back(
      against_exact("GelTip membrane", membrane<double>(0.01146, 0.0455, 0.00052)));
  for (auto& [name, mesh] : test::scan_meshes(is_quick ? 3 : 4)) {
    on.scans.push_back(against_exact(name, std::move(mesh)));
  }
  std::printf(
      "# What each method is off\n\n"
      "Printed by `claims` (benchmarks/claims.cpp). Each cell: mean, 99th percentile and largest, "
      "over all\nvertices from four sources. Icospheres (%zu and %zu vertices) against great "
      "circles: the polyhedron's own\nerror is in it. The GelTip's membrane (%zu vertices) and %zu "
      "scan-like meshes (of %zu vertices the first;\ntests/support/scan_meshes.hpp) against the "
      "exact solver: the median of the meshes and the worst mesh,\neach figure by itself.\n\n"
      "## Distances, relative errors in per cent\n\n",
      on.singles[0].mesh.positions.size(), on.singles[1].mesh.positions.size(),
      on.singles[2].mesh.positions.size(), on.scans.size(), on.scans[0].mesh.positions.size());
  print_distances(on);
  print_refinements(on);
  print_fans();
  print_smooth();
  print_planner(requests);
  print_expected(2 * requests);
  std::printf(
      "\n## Vectors by the heat method\n\n"
      "Against parallel transport along the exact paths, their directions of arrival, and the "
      "exact "
      "log map:\non every mesh those of the polyhedron. Vertices at the cut locus count too, where "
      "two answers are right.\n\n");
  print_head("vectors", on);
  print_vectors(on);
} catch (...) {
  return told();
}
