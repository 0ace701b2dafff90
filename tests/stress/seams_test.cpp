#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "stress/kept_meshes.hpp"
#include "stress/shrinking.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"
#include "support/scan_meshes.hpp"

// Sources where one case becomes another: at a hair's breadth from vertices and edges, several of
// them, with start distances, on meshes that are thin, tiny, huge or far from the origin.
// SITUATIONS=100000 SEED=7 stress.seams makes a long run; what fails is shrunk and printed.

using namespace gelight;
using stress::Method;
using stress::Precision;
using stress::Sources;
using test::Random;
using test::uniform;
using test::uniform_index;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

// --- situations ----------------------------------------------------------------------------------

/// A source, told by vertices so that it outlives faces that are dropped.
struct Spot {
  std::vector<Index> corners;  // one of a vertex, two of an edge, three of a face
  std::array<double, 3> weights{1, 0, 0};
  double start = 0;
};

struct Situation {
  Mesh<double> mesh;
  std::vector<Spot> spots;
};

bool has(const std::array<Index, 3>& face, const std::vector<Index>& corners) {
  return std::all_of(corners.begin(), corners.end(),
                     [&](Index v) { return std::find(face.begin(), face.end(), v) != face.end(); });
}

/// The place of a spot, or nothing where its face has gone.
std::optional<SurfacePoint<double>> point_of(const Mesh<double>& mesh, const Spot& spot) {
  const auto face =
      std::find_if(mesh.faces.begin(), mesh.faces.end(),
                   [&](const std::array<Index, 3>& f) { return has(f, spot.corners); });
  if (face == mesh.faces.end()) return std::nullopt;
  SurfacePoint<double> point = vertex_point<double>(spot.corners[0]);
  point.weights = spot.weights;
  if (spot.corners.size() == 2) {
    point.kind = SurfacePoint<double>::Kind::edge;
    point.element = {spot.corners[0], spot.corners[1]};
  }
  if (spot.corners.size() == 3) {
    point.kind = SurfacePoint<double>::Kind::face;
    point.element = {static_cast<Index>(face - mesh.faces.begin()), -1};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = std::find(spot.corners.begin(), spot.corners.end(), (*face)[k]);
      point.weights[k] = spot.weights[static_cast<std::size_t>(at - spot.corners.begin())];
    }
  }
  return point;
}

/// The sources of a situation; empty where one of them has gone.
Sources sources_of(const Situation& situation) {
  Sources sources;
  for (const Spot& spot : situation.spots) {
    const auto point = point_of(situation.mesh, spot);
    if (!point) return {};
    sources.push_back({*point, spot.start});
  }
  return sources;
}

double extent(const Mesh<double>& mesh) {
  double most = 0;
  const auto& middle = mesh.position(mesh.faces.front()[0]);
  for (const auto& p : mesh.positions) most = std::max(most, stress::gap(p, middle));
  return most;
}

double largest_coordinate(const Mesh<double>& mesh) {
  double most = 0;
  for (const auto& p : mesh.positions) {
    for (const double x : p) most = std::max(most, std::fabs(x));
  }
  return most;
}

// From 1e-20 to 1, as often of one order of magnitude as of any other.
double small_share(Random& random) { return std::pow(10, uniform(random, -20, 0)); }

Spot random_spot(const Mesh<double>& mesh, Random& random) {
  auto face = mesh.faces[static_cast<std::size_t>(
      uniform_index(random, static_cast<Index>(mesh.faces.size())))];
  std::shuffle(face.begin(), face.end(), random);
  const Index kind = uniform_index(random, 5);
  if (kind == 0) return {{face[0]}};
  if (kind == 1) {
    const double t = small_share(random);
    return {{face[0], face[1]}, {1 - t, t, 0}};
  }
  // Inside a face, near a corner, or near an edge.
  const double a = kind < 4 ? small_share(random) / 2 : uniform(random, 0, 0.5);
  const double b = kind < 3 ? small_share(random) / 2 : uniform(random, 0, 0.5);
  return {{face[0], face[1], face[2]}, {1 - a - b, a, b}};
}

/// The catalogue's meshes, those on which something once failed, and scan-like ones; of a size that
/// a test can afford.
const std::vector<Mesh<double>>& pool() {
  static const std::vector<Mesh<double>> all = [] {
    std::vector<Mesh<double>> meshes;
    const auto add = [&](const Mesh<double>& mesh) {
      if (mesh.positions.size() <= 700) meshes.push_back(mesh);
    };
    for (const auto& cases : {stress::shape_cases(), stress::topology_cases()}) {
      for (const auto& one : cases) {
        if (!one.problems) continue;
        for (const auto& problem : one.problems(Precision::in_double)) add(problem.mesh);
      }
    }
    for (const auto& kept : stress::kept_meshes()) add(kept.second);
    for (const auto& scan : test::scan_meshes(3)) add(scan.mesh);
    return meshes;
  }();
  return all;
}

double mean_edge(const Mesh<double>& mesh) { return test::scans::mean_edge(mesh); }

Situation random_situation(Random& random) {
  const auto happens = [&](double chance) { return uniform(random, 0, 1) < chance; };
  Situation situation;
  Mesh<double>& mesh = situation.mesh;
  mesh = happens(0.5) ? pool()[static_cast<std::size_t>(
                            uniform_index(random, static_cast<Index>(pool().size())))]
                      : test::small_random_mesh(uniform_index(random, 10), random);
  if (happens(0.2)) {
    const double factor = std::pow(10, uniform(random, 0, 4));
    const auto axis = static_cast<std::size_t>(uniform_index(random, 3));
    for (auto& p : mesh.positions) p[axis] *= factor;
  }
  const double scale = happens(0.3) ? std::pow(10, uniform(random, -6, 6)) : 1;
  const double away = happens(0.3) ? mean_edge(mesh) * std::pow(10, uniform(random, 0, 6)) : 0;
  for (auto& p : mesh.positions) {
    for (double& x : p) x = (x + away) * scale;
  }
  const Index spots = happens(0.5) ? 1 : 1 + uniform_index(random, 5);
  for (Index i = 0; i < spots; ++i) {
    situation.spots.push_back(random_spot(mesh, random));
    if (!happens(0.3)) continue;
    // Of both signs, from next to nothing to far beyond the mesh.
    const double size = mean_edge(mesh) * std::pow(10, uniform(random, -6, 4));
    situation.spots.back().start = happens(0.5) ? size : -size;
  }
  return situation;
}

// --- properties ----------------------------------------------------------------------------------

/// What is wrong with a situation, or nothing.
using Property = std::function<std::string(const Situation&)>;

std::string first_difference(const std::vector<double>& a, const std::vector<double>& b,
                             const std::function<double(std::size_t)>& room) {
  for (std::size_t v = 0; v < a.size(); ++v) {
    if (a[v] == b[v]) continue;
    if (std::fabs(a[v] - b[v]) <= room(v)) continue;
    std::ostringstream out;
    out.precision(17);
    out << "vertex " << v << ": " << a[v] << ", " << b[v] << ", may differ by " << room(v);
    return out.str();
  }
  return "";
}

std::vector<double> ask(const Method& method, const Mesh<double>& mesh, const Sources& sources) {
  return method.make(mesh, Precision::in_double)->distance(sources);
}

bool is_exact(const Method& method) { return method.name == "exact"; }
bool is_heat(const Method& method) { return !method.keeps_edges; }

/// Of distances that start as late as these.
double rounding(const Situation& situation) {
  double size = extent(situation.mesh);
  for (const Spot& spot : situation.spots) size = std::max(size, std::fabs(spot.start));
  return 1e-12 * size;
}

// I2 to I5 of every solver, and in its own face a source is no farther than the straight line (I1).
std::string keeps_invariants(const Situation& situation) {
  const stress::Problem problem{"", situation.mesh, sources_of(situation)};
  for (const Method& method : stress::methods()) {
    const auto distance = ask(method, problem.mesh, problem.sources);
    stress::Findings findings;
    stress::check_invariants(method, problem, distance, Precision::in_double, findings,
                             rounding(situation));
    if (!findings.faults().empty()) return method.name + ": " + findings.faults().front();
    if (is_heat(method)) continue;
    for (std::size_t s = 0; s < problem.sources.size(); ++s) {
      const auto& source = problem.sources[s];
      for (const Index v : situation.spots[s].corners) {
        const double straight =
            source.distance + stress::gap(problem.mesh, source.point, problem.mesh.position(v));
        if (distance[static_cast<std::size_t>(v)] <= straight + rounding(situation)) continue;
        return method.name + ": vertex " + std::to_string(v) +
               " is farther from a source in its own face than the straight line";
      }
    }
  }
  return "";
}

// The nearest of several sources counts, as if each were alone.
std::string takes_the_nearest(const Situation& situation) {
  const Sources sources = sources_of(situation);
  if (sources.size() < 2) return "";
  for (const Method& method : stress::methods()) {
    if (is_heat(method)) continue;
    const auto together = ask(method, situation.mesh, sources);
    std::vector<double> nearest(together.size(), inf);
    for (const auto& source : sources) {
      const auto alone = ask(method, situation.mesh, {source});
      for (std::size_t v = 0; v < nearest.size(); ++v) nearest[v] = std::min(nearest[v], alone[v]);
    }
    const auto fault = first_difference(together, nearest, [&](std::size_t) {
      return rounding(situation) + method.jump * mean_edge(situation.mesh);
    });
    if (!fault.empty()) return method.name + ", all sources and the nearest alone, " + fault;
  }
  return "";
}

// The first source alone, as a vertex of the mesh.
std::optional<Situation> with_vertex_at_source(Situation situation) {
  const Spot spot = situation.spots.front();
  Mesh<double>& mesh = situation.mesh;
  const auto point = point_of(mesh, spot);
  if (spot.corners.size() < 2 || !point) return std::nullopt;
  const auto middle = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back(stress::position(mesh, *point));
  const std::size_t faces = mesh.faces.size();
  for (std::size_t f = 0; f < faces; ++f) {
    if (!has(mesh.faces[f], spot.corners)) continue;
    const auto whole = mesh.faces[f];
    // One face for each corner of the spot, which the new vertex takes the place of.
    for (std::size_t k = 0; k < spot.corners.size(); ++k) {
      auto part = whole;
      std::replace(part.begin(), part.end(), spot.corners[k], middle);
      if (k == 0) mesh.faces[f] = part;
      if (k > 0) mesh.faces.push_back(part);
    }
  }
  situation.spots = {{{middle}, {1, 0, 0}, spot.start}};
  return situation;
}

// Exact distances from a point are those from a vertex put there. The position of that vertex is
// rounded, and off the face it was in by as much as that.
std::string is_like_a_vertex(const Situation& situation) {
  const auto other = with_vertex_at_source(situation);
  if (!other || !check(other->mesh).is_accepted()) return "";
  const double moved =
      8 * std::numeric_limits<double>::epsilon() * largest_coordinate(situation.mesh);
  const Method& exact = stress::methods()[3];
  const auto before = ask(exact, situation.mesh, {sources_of(situation).front()});
  auto after = ask(exact, other->mesh, sources_of(*other));
  after.pop_back();
  const auto fault = first_difference(
      before, after, [&](std::size_t) { return moved + 10 * rounding(situation); });
  return fault.empty() ? "" : "from a point and from a vertex put there, " + fault;
}

// A source that moves by x changes no distance by more than x, and what the method may be off.
std::string is_continuous(const Situation& situation) {
  for (std::size_t corner = 0; corner < 3; ++corner) {
    // All of what the weight of a corner is goes to the first one.
    const Spot& spot = situation.spots.front();
    if (corner >= spot.corners.size()) continue;
    Situation moved = situation;
    Spot& to = moved.spots.front();
    if (corner == 0) {
      to = {{spot.corners[0]}, {1, 0, 0}, spot.start};
    } else {
      to.weights[0] += to.weights[corner];
      to.weights[corner] = 0;
    }
    const auto& mesh = situation.mesh;
    const Sources sources = sources_of(situation), others = sources_of(moved);
    std::array<double, 3> away{};
    for (std::size_t k = 0; k < spot.corners.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        away[c] += (spot.weights[k] - (k < to.corners.size() ? to.weights[k] : 0)) *
                   (mesh.position(spot.corners[k])[c] - mesh.position(spot.corners[0])[c]);
      }
    }
    const double way = std::hypot(away[0], away[1], away[2]);
    for (const Method& method : stress::methods()) {
      if (!is_exact(method)) continue;
      const auto before = ask(method, mesh, sources), after = ask(method, mesh, others);
      const auto fault =
          first_difference(before, after, [&](std::size_t) { return way + rounding(situation); });
      if (!fault.empty()) {
        return method.name + ", the first source moved to weights " +
               std::to_string(to.weights[0]) + ", " + std::to_string(to.weights[1]) + ", " +
               std::to_string(to.weights[2]) + ", " + fault;
      }
    }
  }
  return "";
}

// I6 and I7: from any source to any other, without their start distances.
std::string is_a_metric(const Situation& situation) {
  const ExactSolver solver(situation.mesh, {.keep_windows = true});
  const Sources sources = sources_of(situation);
  const std::size_t n = std::min<std::size_t>(sources.size(), 3);
  std::array<std::array<double, 3>, 3> d{};
  for (std::size_t i = 0; i < n; ++i) {
    const auto field = solver.solve(sources[i].point);
    for (std::size_t j = 0; j < n; ++j) d[i][j] = field.distance(sources[j].point);
  }
  const double room = 1e-12 * extent(situation.mesh);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(d[i][i] <= room)) return "a source is " + std::to_string(d[i][i]) + " from itself";
    for (std::size_t j = 0; j < n; ++j) {
      const auto pair = std::to_string(i) + " and " + std::to_string(j);
      if (d[i][j] != d[j][i] && !(std::fabs(d[i][j] - d[j][i]) <= room)) {
        return "sources " + pair + " are " + std::to_string(d[i][j]) + " apart, and " +
               std::to_string(d[j][i]);
      }
      for (std::size_t k = 0; k < n; ++k) {
        if (d[i][j] > d[i][k] + d[k][j] + room) return "a way round is shorter than " + pair;
      }
    }
  }
  return "";
}

// I8: moved back to the origin, where every difference of positions stays the same bit for bit, and
// of half the size.
std::string is_intrinsic(const Situation& situation) {
  const Mesh<double>& mesh = situation.mesh;
  const Sources sources = sources_of(situation);
  const auto origin = mesh.positions.front();
  Mesh<double> near = mesh, half = mesh;
  bool is_same = true;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (std::size_t c = 0; c < 3; ++c) {
      near.positions[v][c] -= origin[c];
      is_same &= near.positions[v][c] + origin[c] == mesh.positions[v][c];
      half.positions[v][c] /= 2;
    }
  }
  Sources half_sources = sources;
  for (auto& source : half_sources) source.distance /= 2;
  for (const Method& method : stress::methods()) {
    const auto before = ask(method, mesh, sources);
    auto after = ask(method, half, half_sources);
    for (double& d : after) d *= 2;
    // What a linear solve makes of rounding, on thin triangles.
    const double room_for = is_heat(method) ? 1e6 * rounding(situation) : rounding(situation);
    const auto room = [&](std::size_t) { return room_for; };
    if (const auto fault = first_difference(before, after, room); !fault.empty())
      return method.name + ", of half the size, " + fault;
    if (!is_same) continue;
    if (const auto fault = first_difference(before, ask(method, near, sources), room);
        !fault.empty())
      return method.name + ", moved to the origin, " + fault;
  }
  return "";
}

// Solvers compute in double: float's answer is that of double, rounded.
std::string is_the_same_in_float(const Situation& situation) {
  const Mesh<double> mesh = stress::rounded_to_float(situation.mesh);
  if (!check(mesh).is_accepted()) return "";
  Sources sources = sources_of(situation);
  for (auto& source : sources) {
    source.point = source.point.cast<float>().cast<double>();
    source.distance = double{static_cast<float>(source.distance)};
  }
  for (const Method& method : stress::methods()) {
    const auto in_float = method.make(mesh, Precision::in_float)->distance(sources);
    const auto in_double = ask(method, mesh, sources);
    for (std::size_t v = 0; v < in_float.size(); ++v) {
      const double rounded = double{static_cast<float>(in_double[v])};
      if (in_float[v] == rounded) continue;
      const double unit = double{std::numeric_limits<float>::epsilon()} * std::fabs(rounded);
      if (std::fabs(in_float[v] - rounded) <= unit + rounding(situation)) continue;
      return method.name + ": vertex " + std::to_string(v) + " is " + std::to_string(in_float[v]) +
             " in float, " + std::to_string(in_double[v]) + " in double";
    }
  }
  return "";
}

// Between a certificate's bounds lies the exact distance, but for the exact solver's own rounding.
std::string is_within_bounds(const Situation& situation) {
  const Sources sources = sources_of(situation);
  const std::span<const Source<double>> span(sources);
  const auto exact = ExactSolver(situation.mesh).distance(span);
  const auto bounds = Certifier(situation.mesh).bounds(span, exact);
  for (std::size_t v = 0; v < exact.size(); ++v) {
    const double d = exact[v], room = rounding(situation);
    if (d == inf && bounds.lower[v] == inf && bounds.upper[v] == inf) continue;
    if (bounds.lower[v] <= d + room && bounds.upper[v] >= d - room) continue;
    std::ostringstream out;
    out.precision(17);
    out << "vertex " << v << " at " << d << " is not between " << bounds.lower[v] << " and "
        << bounds.upper[v];
    return out.str();
  }
  return "";
}

struct Named {
  std::string name;
  Property property;
};

const std::vector<Named>& properties() {
  // An exception is a fault, too.
  const auto guarded = [](const Property& property) -> Property {
    return [property](const Situation& situation) -> std::string {
      try {
        return property(situation);
      } catch (const std::exception& error) {
        return std::string("an exception: ") + error.what();
      }
    };
  };
  static const std::vector<Named> all{{"invariants", guarded(keeps_invariants)},
                                      {"the nearest source", guarded(takes_the_nearest)},
                                      {"an inserted vertex", guarded(is_like_a_vertex)},
                                      {"continuity", guarded(is_continuous)},
                                      {"metric", guarded(is_a_metric)},
                                      {"place and size", guarded(is_intrinsic)},
                                      {"float", guarded(is_the_same_in_float)},
                                      {"bounds", guarded(is_within_bounds)}};
  return all;
}

// --- shrinking -----------------------------------------------------------------------------------

/// Without vertices that no face has.
Situation without_unused(const Situation& situation) {
  Situation out;
  std::map<Index, Index> now;
  for (auto face : situation.mesh.faces) {
    for (Index& v : face) {
      const auto [entry, is_new] = now.emplace(v, static_cast<Index>(now.size()));
      if (is_new) out.mesh.positions.push_back(situation.mesh.position(v));
      v = entry->second;
    }
    out.mesh.faces.push_back(face);
  }
  out.spots = situation.spots;
  for (Spot& spot : out.spots) {
    for (Index& v : spot.corners) v = now.at(v);
  }
  return out;
}

Situation shrunk(Situation situation, const Property& property) {
  const auto fails = [&](const Situation& candidate) {
    return !sources_of(candidate).empty() && !property(candidate).empty();
  };
  for (std::size_t i = situation.spots.size(); i-- > 0 && situation.spots.size() > 1;) {
    Situation fewer = situation;
    fewer.spots.erase(fewer.spots.begin() + static_cast<std::ptrdiff_t>(i));
    if (fails(fewer)) situation = fewer;
  }
  for (std::size_t i = 0; i < situation.spots.size(); ++i) {
    Situation plain = situation;
    plain.spots[i].start = 0;
    if (fails(plain)) situation = plain;
  }
  situation.mesh = stress::shrunk(situation.mesh, [&](const Mesh<double>& mesh) {
    return fails({mesh, situation.spots});
  });
  const Situation tidy = without_unused(situation);
  return fails(tidy) ? tidy : situation;
}

std::string literal(const Situation& situation) {
  std::ostringstream out;
  out.precision(17);
  out << '{' << stress::literal(situation.mesh) << ",\n {";
  for (std::size_t i = 0; i < situation.spots.size(); ++i) {
    const auto& [corners, weights, start] = situation.spots[i];
    out << (i > 0 ? ", {{" : "{{");
    for (std::size_t k = 0; k < corners.size(); ++k) out << (k > 0 ? ", " : "") << corners[k];
    out << "}, {" << weights[0] << ", " << weights[1] << ", " << weights[2] << "}, " << start
        << '}';
  }
  out << "}}";
  return out.str();
}

}  // namespace

TEST_CASE("every property holds where one case becomes another") {
  const int situations = stress::from_environment("SITUATIONS", 150);
  const int seed = stress::from_environment("SEED", 1);
  int failures = 0;
  for (int i = 0; i < situations; ++i) {
    Random random(static_cast<std::uint64_t>(seed) * 1000003 + static_cast<std::uint64_t>(i));
    const Situation situation = random_situation(random);
    if (!check(situation.mesh).is_accepted()) continue;
    for (const auto& [name, property] : properties()) {
      const std::string fault = property(situation);
      if (fault.empty()) continue;
      // Shrinking takes its time, and the first failures tell most.
      const Situation small = ++failures > 5 ? situation : shrunk(situation, property);
      FAIL_CHECK("seed " << seed << ", situation " << i << ", " << name << ": " << fault
                         << "\nsmall: " << property(small) << "\n"
                         << literal(small));
    }
  }
}
