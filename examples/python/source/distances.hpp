#pragma once

// What every distance solver answers.

#include "arrays.hpp"
#include "points.hpp"

inline constexpr const char* distance_words =
    "Distance of every vertex from the nearest source, float64 (n,), in the unit of the positions; "
    "+inf where no path leads.\n\nsources: a vertex, a SurfacePoint or a Source, or several of "
    "them; an array of vertices. Raises ValueError for one that is not of the surface.";

/// A caller's packed row of doubles, to be written to.
inline std::span<double> row_to_write(py::array& out) {
  if (!has_type<double>(out)) {
    throw py::type_error("the output has numbers of type " +
                         py::str(out.dtype()).cast<std::string>() + ", not float64");
  }
  gelight::detail::require(out.ndim() == 1, "the output has shape ", shape_text(out));
  if ((out.flags() & py::array::c_style) == 0) {
    throw py::type_error("the output's numbers do not lie side by side, one stands " +
                         std::to_string(out.strides(0)) + " bytes after the other");
  }
  gelight::detail::require(is_aligned(out), "the output's numbers are not aligned");
  gelight::detail::require(out.writeable(), "the output is read-only");
  return {static_cast<double*>(out.mutable_data()), static_cast<std::size_t>(out.size())};
}

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
          [](const Solver& self, py::handle out, py::handle sources) {
            const auto from = sources_in(sources);
            py::array array = array_itself(out, "the output");
            const std::span<double> to = row_to_write(array);
            without_gil([&] {
              self.distance_into(to, std::span<const gelight::Source<double>>(from));
              return 0;
            });
          },
          "out"_a, "sources"_a, "The same, into the caller's array: float64 (n,), packed.")
      .def_property_readonly(
          "surface", [](const Solver& self) { return self.surface(); },
          "The surface that the solver works on.");
}
