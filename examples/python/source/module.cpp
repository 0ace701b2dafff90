// The module gelight: one file a topic (topics.hpp).

#include <pybind11/pybind11.h>

#include <exception>

#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/version.hpp"
#include "topics.hpp"

namespace py = pybind11;

PYBIND11_MODULE(_gelight, m) {
  m.attr("__name__") = "gelight";  // where people find what is here
  m.attr("__version__") = std::to_string(GELIGHT_VERSION_MAJOR) + "." +
                          std::to_string(GELIGHT_VERSION_MINOR) + "." +
                          std::to_string(GELIGHT_VERSION_PATCH);

  py::register_exception<gelight::InvalidInput>(m, "InvalidInput", PyExc_ValueError).doc() =
      "Input that cannot be used; the text names the value and where it was found.";
  py::register_exception<gelight::Cancelled>(m, "Cancelled", PyExc_RuntimeError).doc() =
      "Work that the caller's `cancelled` ended.";
  py::register_exception<gelight::MemoryLimit>(m, "MemoryLimit", PyExc_MemoryError).doc() =
      "Work that would take more memory than its options allow.";

  bind_points(m);
  bind_surface(m);
  bind_operators(m);
  bind_paths_on(m);
  bind_solvers(m);
  bind_heat(m);
  bind_exact(m);
  bind_paths(m);
  bind_smooth(m);
  bind_plan(m);
  bind_rows(m);
  bind_transport(m);
  bind_images(m);
  bind_similarity(m);
  bind_light(m);
#if defined(GELIGHT_HAS_EMBREE)
  bind_traced(m);
#endif
  bind_membranes(m);
  bind_simulators(m);
  bind_renderers(m);
  bind_see_through(m);
  bind_dots(m);
  bind_markers(m);
  bind_calibration(m);
#if defined(GELIGHT_HAS_STB)
  bind_files(m);
#endif
  bind_presets(m);
  bind_sensor_plan(m);

  bind_values();
  guard_classes(m);
}
