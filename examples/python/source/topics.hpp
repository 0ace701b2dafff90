#pragma once

// What each file adds to the module.

#include <pybind11/pybind11.h>

void bind_points(pybind11::module_& m);
void bind_paths_on(pybind11::module_& m);
void bind_surface(pybind11::module_& m);
void bind_operators(pybind11::module_& m);
void bind_solvers(pybind11::module_& m);
void bind_heat(pybind11::module_& m);
void bind_exact(pybind11::module_& m);
void bind_paths(pybind11::module_& m);
void bind_smooth(pybind11::module_& m);
void bind_rows(pybind11::module_& m);
void bind_plan(pybind11::module_& m);
void bind_transport(pybind11::module_& m);
void bind_images(pybind11::module_& m);
void bind_similarity(pybind11::module_& m);
void bind_files(pybind11::module_& m);  // where stb's headers were found
void bind_light(pybind11::module_& m);
void bind_traced(pybind11::module_& m);  // where Embree was found
void bind_membranes(pybind11::module_& m);
void bind_simulators(pybind11::module_& m);
void bind_renderers(pybind11::module_& m);
void bind_see_through(pybind11::module_& m);
void bind_dots(pybind11::module_& m);
void bind_markers(pybind11::module_& m);
void bind_calibration(pybind11::module_& m);
void bind_presets(pybind11::module_& m);
void bind_sensor_plan(pybind11::module_& m);

// When all classes are there.
void bind_values();
void guard_classes(pybind11::module_& m);
