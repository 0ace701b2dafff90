// Distances to an error rather than by a method, and proofs of errors.

#include "gelight/geodesic/plan.hpp"

#include <memory>

#include "distances.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/measured_plan_costs.hpp"
#include "hook.hpp"
#include "points.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::Assurance;
using gelight::DistanceTruth;
using gelight::ErrorNorm;
using gelight::MethodCost;
using gelight::PlanCosts;
using gelight::PlanMethod;
using gelight::RelativeError;
using Bounds = gelight::DistanceBounds<double>;
using Certifier = gelight::Certifier<double>;
using Plan = gelight::DistancePlan;
using Planned = gelight::PlannedDistances<double>;
using Planner = gelight::DistancePlanner<double>;
using FromSources = std::span<const gelight::Source<double>>;

namespace {

py::array_t<double> numbers_of(const std::vector<double>& numbers, const py::object& owner) {
  return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data(), owner);
}

void bind_certifier(py::module_& m) {
  py::class_<RelativeError>(m, "RelativeError",
                            "How far distances can be from the exact ones, as a share of these.")
      .def(py::init([](double mean, double max) {
             return RelativeError{mean, max};
           }),
           "mean"_a, "max"_a)
      .def_readonly("mean", &RelativeError::mean, "Over the vertices that are reached.")
      .def_readonly("max", &RelativeError::max, "The largest of all.");
  py::class_<Bounds>(m, "DistanceBounds",
                     "Two numbers between which the exact distance of each vertex lies.")
      .def_property_readonly(
          "lower",
          [](const py::object& self) { return numbers_of(self.cast<const Bounds&>().lower, self); },
          "Of each vertex, float64 (n,).")
      .def_property_readonly(
          "upper",
          [](const py::object& self) { return numbers_of(self.cast<const Bounds&>().upper, self); },
          "Of each vertex, float64 (n,).")
      .def(
          "error_of",
          [](const Bounds& self, py::handle distances) {
            return self.error_of(span_of(numbers_in<double>(distances, "distances")));
          },
          "distances"_a, "The largest error that distances (n,) can have, given the bounds.");
  py::class_<Certifier>(m, "Certifier",
                        "Proved bounds on the exact distance of every vertex, from approximate "
                        "distances of any origin.")
      .def(py::init([](const Surface& surface) {
             return without_gil([&] { return Certifier(surface); });
           }),
           "surface"_a)
      .def(
          "bounds",
          [](const Certifier& self, py::handle sources, py::handle distances,
             py::object cancelled) {
            const auto from = sources_in(sources);
            const auto numbers = numbers_in<double>(distances, "distances");
            const auto hook = hook_of(std::move(cancelled));
            return without_gil(
                [&] { return self.bounds(FromSources(from), span_of(numbers), hook); });
          },
          "sources"_a, "distances"_a, "cancelled"_a = py::none(),
          "Bounds on the distance from sources, given distances (n,) from there, any of which may "
          "be wrong.");
}

void bind_costs(py::module_& m) {
  py::class_<MethodCost>(m, "MethodCost", "What a method, or a check, costs on a machine.")
      .def(py::init([](double setup_ns, double query_ns, double growth, double bytes) {
             return MethodCost{setup_ns, query_ns, growth, bytes};
           }),
           "setup_ns"_a = 0.0, "query_ns"_a = 0.0, "growth"_a = 0.0, "bytes"_a = 0.0,
           "Nanoseconds a vertex of set-up, and of a query on a mesh of 10,000 vertices; the power "
           "of the number of vertices by which that grows; bytes a vertex, beyond the mesh.")
      .def_readwrite("setup_ns", &MethodCost::setup_ns, "Nanoseconds a vertex.")
      .def_readwrite("query_ns", &MethodCost::query_ns,
                     "Nanoseconds a vertex on a mesh of 10,000 vertices.")
      .def_readwrite("growth", &MethodCost::growth,
                     "Power of the number of vertices by which a query grows.")
      .def_readwrite("bytes", &MethodCost::bytes, "A vertex, beyond the mesh.")
      .def("seconds", &MethodCost::seconds, "vertices"_a, "queries"_a,
           "Of so many queries that share their set-up.");
  py::class_<PlanCosts>(m, "PlanCosts",
                        "What the methods that DistancePlanner chooses from cost, and its checks; "
                        "as it knows them by default.")
      .def(py::init([] { return gelight::PlanRequest{}.costs; }))
      .def_readwrite("dijkstra", &PlanCosts::dijkstra, "DijkstraSolver.")
      .def_readwrite("virtual_source", &PlanCosts::virtual_source, "VirtualSourceSolver.")
      .def_readwrite("fast_marching", &PlanCosts::fast_marching, "FastMarchingSolver.")
      .def_readwrite("exact", &PlanCosts::exact, "ExactSolver.")
      .def_readwrite("certificate", &PlanCosts::certificate, "Bounds of an approximate answer.")
      .def_readwrite("paths", &PlanCosts::paths,
                     "Following some back through an approximate answer.")
      .def_readwrite("sample_share", &PlanCosts::sample_share,
                     "Of checking one target exactly, as a share of an exact query.");
  m.def(
      "measured_plan_costs",
      [](py::object cancelled) {
        const auto hook = hook_of(std::move(cancelled));
        return without_gil([&] { return gelight::measured_plan_costs<double>(hook); });
      },
      "cancelled"_a = py::none(), "What they cost on the machine that runs this, a PlanCosts.");
}

// A callable of Python that the library holds and copies while the interpreter is not its own.
std::shared_ptr<py::object> held(py::object callable) {
  return {new py::object(std::move(callable)), [](py::object* object) {
            const py::gil_scoped_acquire acquire;
            delete object;
          }};
}

PlanMethod::Query query_of(py::object query) {
  return [query = held(std::move(query))](FromSources sources) {
    const py::gil_scoped_acquire acquire;
    const auto distances = numbers_in<double>(
        (*query)(std::vector<gelight::Source<double>>(sources.begin(), sources.end())),
        "a method's distances");
    const auto numbers = span_of(distances);
    return std::vector<double>(numbers.begin(), numbers.end());
  };
}

void bind_methods(py::module_& m) {
  py::class_<PlanMethod>(m, "PlanMethod",
                         "A method of the caller's own for DistancePlanner to choose from.")
      .def(py::init([](std::string name, const MethodCost& cost, const RelativeError& error,
                       py::object make) {
             if (PyCallable_Check(make.ptr()) == 0) {
               throw py::type_error("make is " + py::repr(make).cast<std::string>() +
                                    ", which cannot be called");
             }
             const auto maker = [make = held(std::move(make))](const Surface& surface) {
               const py::gil_scoped_acquire acquire;
               return query_of((*make)(surface));
             };
             return PlanMethod{std::move(name), cost, error, maker};
           }),
           "name"_a, "cost"_a, "error"_a, "make"_a,
           "make(surface) sets the method up and returns its queries: query(sources), of a list of "
           "Sources, is the distance of every vertex from the nearest, (n,). cost: as measured on "
           "the machine of the request's costs; error: what it is off at most from one source.")
      .def_readonly("name", &PlanMethod::name, "What plans and answers call it.")
      .def_readonly("cost", &PlanMethod::cost, "On the machine of the request's costs.")
      .def_readonly("error", &PlanMethod::error, "What it is off at most from one source.");
}

void bind_results(py::module_& m) {
  py::class_<Plan>(m, "DistancePlan", "What was chosen, and why.")
      .def_readonly(
          "method", &Plan::method,
          "The solver: dijkstra, fast_marching, virtual_source, exact, smooth or one of the "
          "caller's own.")
      .def_readonly("expected_to_satisfy", &Plan::expected_to_satisfy,
                    "Whether tolerance, assurance and limits can all be met.")
      .def_readonly("expected_error", &Plan::expected_error, "In the norm asked for.")
      .def_readonly("unfamiliar", &Plan::unfamiliar,
                    "What of the mesh is beyond experience; empty where nothing is.")
      .def_readonly("seconds", &Plan::seconds, "Estimate for all queries, with checks.")
      .def_readonly("bytes", &Plan::bytes, "Estimate beyond the mesh.")
      .def_readonly("refine_to", &Plan::refine_to,
                    "The mean edge length that would do, where the mesh is too coarse; or 0.")
      .def_readonly("reason", &Plan::reason, "The choice in words.");
  py::class_<Planned>(m, "PlannedDistances", "Distances with what is known about them.")
      .def_property_readonly(
          "distance",
          [](const py::object& self) {
            return numbers_of(self.cast<const Planned&>().distance, self);
          },
          "Of each vertex, float64 (n,); +inf where no path leads.")
      .def_readonly("method", &Planned::method, "The one whose distances these are.")
      .def_readonly("achieved", &Planned::achieved, "How the error is known.")
      .def_readonly("error", &Planned::error, "Of the distances as they are.")
      .def_readonly("checked", &Planned::checked, "Targets computed exactly.")
      .def_readonly("satisfies", &Planned::satisfies, "Whether the request is kept.")
      .def_readonly("reason", &Planned::reason, "What was done and found, in words.");
}

gelight::PlanRequest request_of(double tolerance, ErrorNorm norm, DistanceTruth truth,
                                Assurance assurance, Index sources, Index samples,
                                py::handle targets, double time_limit, double memory_limit,
                                double slowness, const PlanCosts* costs,
                                std::vector<PlanMethod> methods, py::object cancelled) {
  gelight::PlanRequest request;
  request.tolerance = tolerance;
  request.norm = norm;
  request.truth = truth;
  request.assurance = assurance;
  request.sources = sources;
  request.samples = samples;
  if (!targets.is_none()) {
    const auto vertices = index_row_in(targets, "targets");
    request.targets.assign(vertices.data(), vertices.data() + vertices.size());
  }
  request.time_limit = time_limit;
  request.memory_limit = memory_limit;
  request.slowness = slowness;
  if (costs != nullptr) request.costs = *costs;
  request.methods = std::move(methods);
  request.cancelled = hook_of(std::move(cancelled));
  return request;
}

void bind_planner(py::module_& m) {
  auto planner =
      py::class_<Planner>(m, "DistancePlanner",
                          "Distances to a given error rather than by a given method: chooses the "
                          "cheapest one, runs it, checks it, and escalates to the exact solver.");
  bind_distances(planner);
  planner
      .def(py::init([](const Surface& surface, double tolerance, ErrorNorm norm,
                       DistanceTruth truth, Assurance assurance, Index sources, Index samples,
                       py::handle targets, double time_limit, double memory_limit, double slowness,
                       const PlanCosts* costs, std::vector<PlanMethod> methods,
                       py::object cancelled) {
             const auto request = request_of(tolerance, norm, truth, assurance, sources, samples,
                                             targets, time_limit, memory_limit, slowness, costs,
                                             std::move(methods), std::move(cancelled));
             return without_gil([&] { return Planner(surface, request); });
           }),
           "surface"_a, py::kw_only(), "tolerance"_a = 0.01, "norm"_a = ErrorNorm::mean,
           "truth"_a = DistanceTruth::polyhedral, "assurance"_a = Assurance::certified,
           "sources"_a = 1, "samples"_a = 4, "targets"_a = py::none(),
           "time_limit"_a = gelight::unreachable<double>,
           "memory_limit"_a = gelight::unreachable<double>, "slowness"_a = 1.0,
           "costs"_a = py::none(), "methods"_a = std::vector<PlanMethod>{},
           "cancelled"_a = py::none(),
           "tolerance: largest relative error. sources: how many queries share the set-up. "
           "targets: the vertices that matter, all by default. time_limit: in seconds, "
           "memory_limit: in bytes, as estimated. costs: PlanCosts; methods: PlanMethods to choose "
           "from besides.")
      .def_property_readonly(
          "plan", [](const Planner& self) { return self.plan(); },
          "What was chosen for the request, and why.")
      .def(
          "solve",
          [](const Planner& self, py::handle sources) {
            const auto from = sources_in(sources);
            return without_gil([&] { return self.solve(FromSources(from)); });
          },
          "sources"_a, "The same distances as `distance`, and how far they are off.");
}

}  // namespace

void bind_plan(py::module_& m) {
  py::enum_<ErrorNorm>(m, "ErrorNorm", "Which relative error over the vertices is meant.")
      .value("mean", ErrorNorm::mean)
      .value("max", ErrorNorm::max);
  py::enum_<DistanceTruth>(m, "DistanceTruth", "What distances are compared with.")
      .value("polyhedral", DistanceTruth::polyhedral, "The mesh.")
      .value("smooth", DistanceTruth::smooth, "The surface that it approximates.");
  py::enum_<Assurance>(m, "Assurance", "How an error is known.")
      .value("expected", Assurance::expected, "From experience with such meshes.")
      .value("sampled", Assurance::sampled, "Some targets were computed exactly besides.")
      .value("certified", Assurance::certified, "Proved at every vertex.");
  bind_certifier(m);
  bind_costs(m);
  bind_methods(m);
  bind_results(m);
  bind_planner(m);
}
