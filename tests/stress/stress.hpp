#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/mesh/surface_point.hpp"
#include "gelight/views/mesh_view.hpp"

// The catalogue of inputs on which geodesic and tactile code is known to fail, as a table of cases.

namespace gelight::stress {

using Sources = std::vector<Source<double>>;
enum class Precision { in_double, in_float };

/// A distance solver on one mesh, in one precision; what goes in and out is double.
class Query {
 public:
  Query() = default;
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;
  virtual ~Query() = default;
  [[nodiscard]] virtual std::vector<double> distance(const Sources& sources) const = 0;
  /// The same through distance_into, over what `out` held.
  virtual void distance_into(std::vector<double>& out, const Sources& sources) const = 0;
};

/// A kind of solver, and which invariants its approximation keeps.
struct Method {
  std::string name;
  std::function<std::unique_ptr<Query>(const Mesh<double>&, Precision)> make;
  bool keeps_edges;      ///< |d(i) - d(j)| <= length(ij), and never longer than along edges
  bool keeps_space;      ///< never shorter than through space
  double slack = 1e-12;  ///< by what share it may miss them
  /// By how many mean edges distances may change where the source does not, or moves by next to
  /// nothing: with another one beside it, or off a vertex. Claimed of methods that keep edges.
  double jump = 0;
};

[[nodiscard]] const std::vector<Method>& methods();
[[nodiscard]] std::vector<Method> graph_methods();
[[nodiscard]] std::vector<Method> exact_methods();
[[nodiscard]] std::vector<Method> heat_methods();

/// Largest relative error of a distance that passes: mean over the vertices, and at the worst.
/// Without numbers only the invariants are claimed: finite where a path leads, infinite elsewhere.
struct Bound {
  double mean = std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
};

/// A bound for each of methods().
using Claims = std::vector<Bound>;

/// Of a case with problems. A bound that is loose fails too: one that is more than twice of what is
/// measured in double, or, where that is rounding, ten times.
[[nodiscard]] const Claims& claims_of(const std::string& name);

/// A mesh with sources and the true distance of each vertex; NaN where none is known.
struct Problem {
  std::string name;
  Mesh<double> mesh;
  Sources sources;
  std::vector<double> truth{};
  double slack = 1;  ///< by what the exact solver's rounding grows: the triangles' aspect ratio
  /// What float's rounding of the positions may add to the error; 0 to have it estimated.
  double float_rounding = 0;
};

/// What a case that is no table of distances says of itself.
class Findings {
 public:
  void expect(bool holds, const std::string& what) {
    ++count_;
    if (!holds) faults_.push_back(what);
  }
  /// Expects `act` to throw InvalidInput with a text that contains `part`.
  void expect_refusal(const std::string& part, const std::function<void()>& act);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] const std::vector<std::string>& faults() const { return faults_; }

 private:
  int count_ = 0;
  std::vector<std::string> faults_;
};

struct Case {
  std::string name;      ///< its number in the catalogue: "8", "image 3"
  std::string input;     ///< what it is
  std::string reason{};  ///< of the errors
  std::function<std::vector<Problem>(Precision)> problems{};
  std::string others{};  ///< what is shown besides distances
  std::function<void(Findings&, Precision)> more{};
  std::string all{};  ///< what `more` shows of every distance solver
};

[[nodiscard]] std::vector<Case> shape_cases();
[[nodiscard]] std::vector<Case> topology_cases();
[[nodiscard]] std::vector<Case> vector_cases();
[[nodiscard]] std::vector<Case> image_cases();

/// The invariants that a method's distances keep on any mesh, but for its slack, rounding, and
/// `absolute`.
void check_invariants(const Method& method, const Problem& problem,
                      const std::vector<double>& distance, Precision precision, Findings& findings,
                      double absolute = 0);

/// Runs a case in both precisions; prints a line per solver and problem, returns the faults.
[[nodiscard]] std::vector<std::string> run(const Case& one, bool verbose);

/// What claims.cpp should say of a case: half as much again as is measured now.
[[nodiscard]] std::string measured_claims(const Case& one);

/// The table of tests/README.md: what is measured in double, beside the bounds.
[[nodiscard]] std::string table(const std::vector<Case>& cases);

// --- for the generators --------------------------------------------------------------------------

inline constexpr double pi = std::numbers::pi;
inline constexpr double inf = std::numeric_limits<double>::infinity();
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

[[nodiscard]] inline Sources from(Index vertex) { return {{vertex_point<double>(vertex), 0}}; }

/// Euclidean distances from the nearest source: the truth on a flat convex sheet.
[[nodiscard]] std::vector<double> euclidean(const Mesh<double>& mesh, const Sources& sources);
/// A problem on such a sheet.
[[nodiscard]] Problem flat(std::string name, Mesh<double> mesh, Sources sources);
[[nodiscard]] std::array<double, 3> position(const Mesh<double>& mesh,
                                             const SurfacePoint<double>& point);
[[nodiscard]] double gap(const std::array<double, 3>& a, const std::array<double, 3>& b);
[[nodiscard]] double gap(const Mesh<double>& mesh, const SurfacePoint<double>& point,
                         const std::array<double, 3>& p);
[[nodiscard]] Mesh<double> rounded_to_float(Mesh<double> mesh);

}  // namespace gelight::stress
