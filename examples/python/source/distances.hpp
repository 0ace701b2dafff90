#pragma once

// What every distance solver answers.

#include "arrays.hpp"
#include "points.hpp"

inline constexpr const char* distance_words =
    "Distance of every vertex from the nearest source, float64 (n,), in the unit of the positions; "
    "+inf where no path leads.\n\nsources: a vertex, a SurfacePoint or a Source, or several of "
    "them; an array of vertices. Raises ValueError for one that is not of the surface.";

template <class Class>
void bind_distances(Class& solver) {
  using Solver = typename Class::type;
  using namespace py::literals;
  solver
      .def(
          "distance",
          [](const Solver& self, py::handle sources) {
            const auto from = sources_in(sources);
            return array_of(without_gil(
                [&] { return self.distance(std::span<const gelight::Source<double>>(from)); }));
          },
          "sources"_a, distance_words)
      .def(
          "distance_into",
          [](const Solver& self, py::array_t<double, py::array::c_style> out, py::handle sources) {
            const auto from = sources_in(sources);
            gelight::detail::require(out.ndim() == 1, "the output has shape ", shape_text(out));
            gelight::detail::require(is_aligned(out), "the output's numbers are not aligned");
            const std::span<double> to(out.mutable_data(), static_cast<std::size_t>(out.size()));
            without_gil([&] {
              self.distance_into(to, std::span<const gelight::Source<double>>(from));
              return 0;
            });
          },
          py::arg("out").noconvert(), "sources"_a,
          "The same, into the caller's array: float64 (n,), packed.")
      .def_property_readonly(
          "surface", [](const Solver& self) { return self.surface(); },
          "The surface that the solver works on.");
}
