// Distances from many sources, a row each.

#include "any_solver.hpp"
#include "gelight/geodesic/distance_rows.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "hook.hpp"
#include "points.hpp"
#include "topics.hpp"

using namespace py::literals;
using From = std::span<const gelight::Source<double>>;

namespace {

template <class... Solvers>
AnySolver one_of(py::handle object) {
  std::optional<AnySolver> found;
  const auto is_it = [&]<class Solver>(const Solver*) {
    if (!py::isinstance<Solver>(object)) return false;
    found.emplace(object.cast<const Solver&>());
    return true;
  };
  if ((is_it(static_cast<const Solvers*>(nullptr)) || ...)) return *std::move(found);
  throw py::type_error(py::repr(object).cast<std::string>() + " is no distance solver");
}

gelight::RowOptions options_of(unsigned threads, py::object cancelled) {
  return {threads, hook_of(std::move(cancelled))};
}

void give_rows(py::handle object, py::handle sources, const py::object& take, unsigned threads,
               py::object cancelled) {
  if (PyCallable_Check(take.ptr()) == 0) {
    throw py::type_error("take is " + py::repr(take).cast<std::string>() +
                         ", which cannot be called");
  }
  const AnySolver solver = any_solver(object);
  const auto from = sources_in(sources);
  const auto options = options_of(threads, std::move(cancelled));
  // A copy, which Python may keep: the row itself ends with the call.
  const auto give = [&](Index row, std::span<const double> distances) {
    const py::gil_scoped_acquire acquire;
    take(row, array_of(std::vector<double>(distances.begin(), distances.end())));
  };
  without_gil([&] {
    gelight::distance_rows(solver, From(from), give, options);
    return 0;
  });
}

}  // namespace

AnySolver any_solver(py::handle object) {
  return one_of<gelight::DijkstraSolver<double>, gelight::FastMarchingSolver<double>,
                gelight::VirtualSourceSolver<double>, gelight::HeatSolver<double>,
                gelight::ExactSolver<double>, gelight::SmoothDistanceSolver<double>,
                gelight::DistancePlanner<double>>(object);
}

void bind_rows(py::module_& m) {
  m.def(
      "distance_matrix",
      [](py::handle object, py::handle sources, unsigned threads, py::object cancelled) {
        const AnySolver solver = any_solver(object);
        const auto from = sources_in(sources);
        const auto options = options_of(threads, std::move(cancelled));
        auto matrix =
            without_gil([&] { return gelight::distance_matrix(solver, From(from), options); });
        return array_of<double>(std::move(matrix), {static_cast<py::ssize_t>(from.size()),
                                                    solver.surface().vertex_count()});
      },
      "solver"_a, "sources"_a, py::kw_only(), "threads"_a = 1, "cancelled"_a = py::none(),
      "Distance of every vertex from each of k sources, float64 (k, n), in the unit of the "
      "positions: row i is bit for bit `solver.distance(sources[i])`.\n\n"
      "solver: any distance solver. threads: 0 for as many as the machine has; they share the "
      "solver's factors. Ctrl-C ends the work when the other threads' rows are done. Raises "
      "ValueError, before any row is solved, for a source that is not of "
      "the surface.");
  m.def("distance_rows", &give_rows, "solver"_a, "sources"_a, "take"_a, py::kw_only(),
        "threads"_a = 1, "cancelled"_a = py::none(),
        "The same rows as they come, where the matrix would be too large: calls `take(row, "
        "distances)` with the number of a source and float64 (n,), which may be kept.\n\n"
        "Rows come in any order, on any of the threads, never two at once. What `take` raises ends "
        "the work; rows that were taken before stay taken.");
}
