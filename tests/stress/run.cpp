#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "stress/stress.hpp"

namespace gelight::stress {

namespace {

double largest_coordinate(const Mesh<double>& mesh) {
  double most = 0;
  for (const auto& p : mesh.positions) {
    for (const double x : p) most = std::max(most, std::fabs(x));
  }
  return most;
}

double longest_edge(const Mesh<double>& mesh) {
  double most = 0;
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      most = std::max(most, gap(mesh.position(face[k]), mesh.position(face[(k + 1) % 3])));
    }
  }
  return most;
}

// Positions rounded by half a unit in the last place, and the distance itself, against the shortest
// distance that is asked for.
double float_rounding(const Problem& problem) {
  if (problem.float_rounding > 0) return problem.float_rounding;
  double least = inf;
  for (const double d : problem.truth) least = d > 0 ? std::min(least, d) : least;
  if (least == inf) return 0;
  const double eps = double{std::numeric_limits<float>::epsilon()};
  return 2 * eps * (1 + largest_coordinate(problem.mesh) / least);
}

struct Error {
  double mean = 0, most = 0;
};

// Relative to the truth; where that is zero, to the mesh.
Error error_of(const std::vector<double>& distance, const Problem& problem) {
  Error error;
  double sum = 0;
  int count = 0;
  const double size = largest_coordinate(problem.mesh);
  for (std::size_t v = 0; v < problem.truth.size(); ++v) {
    const double truth = problem.truth[v];
    if (std::isnan(truth)) continue;
    if (truth == inf || distance[v] == inf) {
      if (truth != distance[v]) return {inf, inf};
      continue;
    }
    const double off = std::fabs(distance[v] - truth) / (truth > 0 ? truth : size);
    if (!(off <= error.most)) error.most = off;  // NaN too
    sum += off;
    ++count;
  }
  error.mean = count > 0 ? sum / count : 0;
  return error;
}

std::string text(double x) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.3g", x);
  return out.data();
}

}  // namespace

void check_invariants(const Method& method, const Problem& problem,
                      const std::vector<double>& distance, Precision precision, Findings& findings,
                      double absolute) {
  const Mesh<double> mesh =
      precision == Precision::in_float ? rounded_to_float(problem.mesh) : problem.mesh;
  const auto along_edges =
      DijkstraSolver(mesh).distance(std::span<const Source<double>>(problem.sources));
  const double eps = precision == Precision::in_float
                         ? 4 * double{std::numeric_limits<float>::epsilon()}
                         : 64 * std::numeric_limits<double>::epsilon();
  // Windows lie in the frames of the edges that they cross, whose lengths are rounded.
  const double rounding =
      absolute +
      eps * (precision == Precision::in_float ? largest_coordinate(mesh) : longest_edge(mesh));
  // Solvers that work on lengths make a face without area a little longer.
  const double lengthened = method.slack > 1e-9 ? 1e-7 * longest_edge(mesh) : 0;
  const auto room = [&](double d) {
    return (method.slack + eps) * std::fabs(d) + rounding + lengthened;
  };
  double least_start = inf;
  for (const auto& source : problem.sources) least_start = std::min(least_start, source.distance);
  for (std::size_t v = 0; v < distance.size(); ++v) {
    const double d = distance[v];
    const std::string place = " at vertex " + std::to_string(v) + ": " + text(d);
    findings.expect(!std::isnan(d) && d >= least_start - room(least_start),
                    "a distance less than the start" + place);
    findings.expect((d == inf) == (along_edges[v] == inf), "infinite where it should not" + place);
    if (d == inf) continue;
    if (method.keeps_edges) {
      findings.expect(d <= along_edges[v] + room(along_edges[v]),
                      "longer than " + text(along_edges[v]) + " along edges" + place);
    }
    if (!method.keeps_space) continue;
    double through_space = inf;
    for (const auto& source : problem.sources) {
      through_space =
          std::min(through_space, source.distance + gap(mesh, source.point, mesh.positions[v]));
    }
    findings.expect(d >= through_space - room(through_space),
                    "shorter than " + text(through_space) + " through space" + place);
  }
  if (!method.keeps_edges) return;
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(face[k]);
      const auto b = static_cast<std::size_t>(face[(k + 1) % 3]);
      if (distance[a] == inf) continue;
      const double length = gap(mesh.positions[a], mesh.positions[b]);
      findings.expect(
          std::fabs(distance[a] - distance[b]) <= length + room(std::max(distance[a], distance[b])),
          "vertices " + std::to_string(a) + " and " + std::to_string(b) +
              " differ by more than their edge: " + text(distance[a]) + ", " + text(distance[b]));
    }
  }
}

namespace {

Error run_problem(const Method& method, const Bound& bound, const Problem& problem,
                  Precision precision, bool verbose, Findings& findings) {
  const auto distance = method.make(problem.mesh, precision)->distance(problem.sources);
  check_invariants(method, problem, distance, precision, findings);
  const Error error = error_of(distance, problem);
  const double rounding = precision == Precision::in_float ? float_rounding(problem) : 0;
  if (verbose) {
    std::printf("  %-28s %-24s mean %-9s of %-9s most %-9s of %s\n", problem.name.c_str(),
                method.name.c_str(), text(error.mean).c_str(), text(bound.mean + rounding).c_str(),
                text(error.most).c_str(), text(bound.most + rounding).c_str());
  }
  findings.expect(error.mean <= bound.mean + rounding,
                  "mean error " + text(error.mean) + " beyond " + text(bound.mean + rounding));
  findings.expect(error.most <= bound.most + rounding,
                  "largest error " + text(error.most) + " beyond " + text(bound.most + rounding));
  return error;
}

void widen(Error& error, const Error& other) {
  error.mean = std::max(error.mean, other.mean);
  error.most = std::max(error.most, other.most);
}

// What bounds may be where nothing, or next to it, is measured: some 45 units in the last place, as
// the additions and roots along a path leave them.
constexpr double rounding_floor = 1e-14;
// Errors below this are rounding, of which each compiler makes its own: it sums in another order,
// or fuses products and sums.
constexpr double all_rounding = 1e-12;

// A bound that is far from what is measured would let a defect through.
bool is_tight(double bound, double measured) {
  return bound <= rounding_floor || bound <= 2 * measured ||
         (bound <= all_rounding && bound <= 10 * measured);
}

void check_tightness(const Bound& bound, const Error& measured, Findings& findings) {
  const auto check = [&](const std::string& which, double stated, double seen) {
    if (stated == inf) return;  // nothing is claimed
    findings.expect(is_tight(stated, seen), which + " error is said to be " + text(stated) +
                                                " at most, " + text(seen) + " is measured");
  };
  check("the mean", bound.mean, measured.mean);
  check("the largest", bound.most, measured.most);
}

/// The largest of each method's errors over a case's problems.
std::vector<Error> measured(const Case& one) {
  std::vector<Error> errors(methods().size());
  for (const Problem& problem : one.problems(Precision::in_double)) {
    for (std::size_t m = 0; m < methods().size(); ++m) {
      const auto query = methods()[m].make(problem.mesh, Precision::in_double);
      widen(errors[m], error_of(query->distance(problem.sources), problem));
    }
  }
  return errors;
}

// Half as much again, in two digits.
double roomy(double measured) {
  if (measured <= 0) return rounding_floor;
  const double more =
      std::max(1.5 * measured, std::min(5 * measured, all_rounding));  // rounding differs by more
  const double digit = std::pow(10, std::floor(std::log10(more)) - 1);
  return std::max(rounding_floor, std::ceil(more / digit) * digit);
}

std::string number(double x, const char* format = "%.2g") {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), format, x);
  return out.data();
}
std::string percent(double share) {
  return number(100 * share, share >= 1 ? "%.0f" : "%.2g") + " %";
}

std::string cell(const Error& error, const Bound& bound) {
  if (bound.most <= all_rounding) {
    return "exact: " + number(error.most, "%.0e") + " (" + number(bound.most) + ")";
  }
  const std::string seen = percent(error.mean) + ", " + percent(error.most);
  if (bound.most == inf && bound.mean == inf) return seen + " (finite)";
  return seen + " (" + percent(bound.mean) + (bound.most == inf ? "" : ", " + percent(bound.most)) +
         ")";
}

}  // namespace

const std::vector<Method>& methods() {
  static const std::vector<Method> all = [] {
    std::vector<Method> list = graph_methods();
    for (auto& method : exact_methods()) list.push_back(method);
    for (auto& method : heat_methods()) list.push_back(method);
    return list;
  }();
  return all;
}

void Findings::expect_refusal(const std::string& part, const std::function<void()>& act) {
  try {
    act();
  } catch (const InvalidInput& refusal) {
    const std::string said = refusal.what();
    expect(said.find(part) != std::string::npos,
           "refused with \"" + said + "\", which does not say \"" + part + '"');
    return;
  } catch (const std::exception& other) {
    expect(false, "an exception of another type: " + std::string(other.what()));
    return;
  }
  expect(false, "accepted, where it should say \"" + part + '"');
}

std::vector<std::string> run(const Case& one, bool verbose) {
  std::vector<std::string> faults;
  int count = 0;
  for (const Precision precision : {Precision::in_double, Precision::in_float}) {
    const std::string scalar = precision == Precision::in_float ? "float" : "double";
    if (verbose)
      std::printf("%s, in %s: %s\n", one.name.c_str(), scalar.c_str(), one.input.c_str());
    const auto note = [&](const std::string& place, const auto& act) {
      Findings findings;
      try {
        act(findings);
      } catch (const std::exception& error) {
        findings.expect(false, std::string("an exception: ") + error.what());
      }
      count += findings.count();
      for (std::size_t i = 0; i < std::min<std::size_t>(3, findings.faults().size()); ++i) {
        faults.push_back(one.name + ", " + place + scalar + ": " + findings.faults()[i]);
      }
    };
    const auto problems = one.problems ? one.problems(precision) : std::vector<Problem>{};
    const Claims claims = one.problems ? claims_of(one.name) : Claims{};
    std::vector<Error> errors(methods().size());
    for (const Problem& problem : problems) {
      for (std::size_t m = 0; m < methods().size(); ++m) {
        note(problem.name + ", " + methods()[m].name + " in ", [&](Findings& findings) {
          widen(errors[m],
                run_problem(methods()[m], claims[m], problem, precision, verbose, findings));
        });
      }
    }
    for (std::size_t m = 0; m < methods().size(); ++m) {
      // In float most of an error is the positions' rounding.
      if (problems.empty() || precision == Precision::in_float) break;
      note(methods()[m].name + " in ",
           [&](Findings& findings) { check_tightness(claims[m], errors[m], findings); });
    }
    if (one.more) note("", [&](Findings& findings) { one.more(findings, precision); });
  }
  if (count == 0) faults.push_back(one.name + " checks nothing");
  if (verbose) std::printf("  %d checks\n", count);
  return faults;
}

std::string measured_claims(const Case& one) {
  const auto errors = measured(one);
  std::string out = "{\"" + one.name + "\", {";
  for (std::size_t m = 0; m < errors.size(); ++m) {
    out += m > 0 ? ", " : "";
    const bool is_claimed = claims_of(one.name).size() <= m || claims_of(one.name)[m].most < inf;
    out += is_claimed
               ? "{" + number(roomy(errors[m].mean)) + ", " + number(roomy(errors[m].most)) + "}"
               : "{}";
  }
  return out + "}},\n";
}

std::string table(const std::vector<Case>& cases) {
  std::ostringstream out;
  out << "| | input |";
  for (const Method& method : methods()) out << ' ' << method.name << " |";
  out << " besides | why this much |\n|---|---|";
  for (std::size_t i = 0; i < methods().size() + 2; ++i) out << "---|";
  out << '\n';
  for (const Case& one : cases) {
    out << "| " << one.name << " | " << one.input << " |";
    const auto errors = one.problems ? measured(one) : std::vector<Error>{};
    const Claims claims = one.problems ? claims_of(one.name) : Claims{};
    for (std::size_t m = 0; m < methods().size(); ++m) {
      out << ' ' << (one.problems ? cell(errors[m], claims[m]) : one.all) << " |";
    }
    out << ' ' << one.others << " | " << one.reason << " |\n";
  }
  return out.str();
}

namespace {

std::array<Index, 3> corners_of(const Mesh<double>& mesh, const SurfacePoint<double>& point) {
  using Kind = SurfacePoint<double>::Kind;
  const auto& [a, b] = point.element;
  if (point.kind == Kind::face) return mesh.face(a);
  return {a, point.kind == Kind::edge ? b : a, a};
}

}  // namespace

std::array<double, 3> position(const Mesh<double>& mesh, const SurfacePoint<double>& point) {
  std::array<double, 3> sum{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& corner = mesh.position(corners_of(mesh, point)[k]);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += point.weights[k] * corner[c];
  }
  return sum;
}

double gap(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Differences before weights, so that a point near a vertex keeps its distance from it.
double gap(const Mesh<double>& mesh, const SurfacePoint<double>& point,
           const std::array<double, 3>& p) {
  std::array<double, 3> sum{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& corner = mesh.position(corners_of(mesh, point)[k]);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += point.weights[k] * (corner[c] - p[c]);
  }
  return std::hypot(sum[0], sum[1], sum[2]);
}

std::vector<double> euclidean(const Mesh<double>& mesh, const Sources& sources) {
  std::vector<double> out;
  for (const auto& p : mesh.positions) {
    double least = inf;
    for (const auto& source : sources) {
      least = std::min(least, source.distance + gap(mesh, source.point, p));
    }
    out.push_back(least);
  }
  return out;
}

Problem flat(std::string name, Mesh<double> mesh, Sources sources) {
  auto truth = euclidean(mesh, sources);
  return {std::move(name), std::move(mesh), std::move(sources), std::move(truth)};
}

Mesh<double> rounded_to_float(Mesh<double> mesh) {
  for (auto& p : mesh.positions) {
    for (double& x : p) {
      // Volatile, since g++ 12 with -O3 takes some of the roundings out of the unrolled loop.
      const volatile float rounded = static_cast<float>(x);
      x = double{rounded};
    }
  }
  return mesh;
}

}  // namespace gelight::stress
