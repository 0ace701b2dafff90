#pragma once

// A renderer of a calibrated sensor, compiled in a file of its own.

#include <memory>

#include "any_membrane.hpp"
#include "gelight/concepts/reflectance.hpp"
#include "renderer.hpp"

std::unique_ptr<AnyRenderer> calibrated_renderer(const Camera& camera,
                                                 const ImageView<const float>& rest_depth,
                                                 py::handle sensor, const AnyMembrane* membrane,
                                                 const gelight::FrameOptions& options);
/// Whether an object is a CalibratedSensor.
bool is_calibrated_sensor(py::handle object);
