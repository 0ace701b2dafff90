// Distances from many sources, a row each.

#include <chrono>
#include <exception>
#include <future>
#include <system_error>

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

// Waits for work on other threads and asks for Ctrl-C meanwhile, of which Python tells its main
// thread alone: were that one of those that solve, it would not hear while it waits for the last.
void watch(const std::future<void>& work, CommonEnd& end) {
  const gelight::CancelHook ctrl_c = PythonHook();
  while (work.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    if (end.is_over()) continue;
    try {
      ctrl_c.check(0, "solving rows of distances");
    } catch (...) {
      end.end(std::current_exception());
    }
  }
}

// Does `work` here, or on a thread of its own where there are to be several.
template <class Work>
void work_and_watch(unsigned threads, CommonEnd& end, const Work& work) {
  if (threads == 1) return work();
  std::future<void> running;
  try {
    running = std::async(std::launch::async, work);
  } catch (const std::system_error&) {
    return work();  // there are no more threads
  }
  watch(running, end);
}

// Calls `rows(solver, options, end)`, where whatever the first thread throws ends all.
template <class Rows>
void solve_together(const AnySolver& any, unsigned threads, py::object cancelled,
                    const Rows& rows) {
  CommonEnd end;
  const AnySolver solver(any.surface(),
                         [&](From from) { return end.part([&] { return any.distance(from); }); });
  const auto ask = [&end, hook = hook_of(std::move(cancelled))](double done) {
    return end.part([&] {
      hook.check(done, "solving rows of distances");
      return false;
    });
  };
  without_gil([&] {
    work_and_watch(threads, end, [&] {
      try {
        rows(solver, gelight::RowOptions{threads, ask}, end);
      } catch (...) {
        end.end(std::current_exception());
      }
    });
    end.rethrow();
    return 0;
  });
}

void give_rows(py::handle object, py::handle sources, const py::object& take, unsigned threads,
               py::object cancelled) {
  if (PyCallable_Check(take.ptr()) == 0) {
    throw py::type_error("take is " + py::repr(take).cast<std::string>() +
                         ", which cannot be called");
  }
  const AnySolver solver = any_solver(object);
  const auto from = sources_in(sources);
  // A copy, which Python may keep: the row itself ends with the call.
  const auto give = [&](Index row, std::span<const double> distances) {
    const py::gil_scoped_acquire acquire;
    take(row, array_of(std::vector<double>(distances.begin(), distances.end())));
  };
  solve_together(solver, threads, std::move(cancelled),
                 [&](const auto& together, const auto& options, CommonEnd& end) {
                   const auto give_part = [&](Index row, std::span<const double> distances) {
                     end.part([&] { give(row, distances); });
                   };
                   gelight::distance_rows(together, From(from), give_part, options);
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
        std::vector<double> matrix;
        solve_together(solver, threads, std::move(cancelled),
                       [&](const auto& together, const auto& options, CommonEnd&) {
                         matrix = gelight::distance_matrix(together, From(from), options);
                       });
        return array_of<double>(std::move(matrix), {static_cast<py::ssize_t>(from.size()),
                                                    solver.surface().vertex_count()});
      },
      "solver"_a, "sources"_a, py::kw_only(), "threads"_a = 1, "cancelled"_a = py::none(),
      "Distance of every vertex from each of k sources, float64 (k, n), in the unit of the "
      "positions: row i is bit for bit `solver.distance(sources[i])`.\n\n"
      "solver: any distance solver. threads: 0 for as many as the machine has; they share the "
      "solver's factors. Ctrl-C, or what any thread raises, ends the rows of all where they are. "
      "Raises ValueError, before any row is solved, for a source that is not of the surface.");
  m.def("distance_rows", &give_rows, "solver"_a, "sources"_a, "take"_a, py::kw_only(),
        "threads"_a = 1, "cancelled"_a = py::none(),
        "The same rows as they come, where the matrix would be too large: calls `take(row, "
        "distances)` with the number of a source and float64 (n,), which may be kept.\n\n"
        "Rows come in any order, on any of the threads, never two at once. What `take` raises ends "
        "the work; rows that were taken before stay taken.");
}
