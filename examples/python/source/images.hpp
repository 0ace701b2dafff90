#pragma once

// What images of sensors have in common.

#include "arrays.hpp"
#include "gelight/sensor/background.hpp"

using Camera = gelight::Camera<float>;
using Raster = gelight::Raster<float>;
using Background = gelight::Background<float>;

/// None, a colour, or an image (h, w) or (h, w, 3) of float numbers or uint8.
Background background_in(py::handle object);
