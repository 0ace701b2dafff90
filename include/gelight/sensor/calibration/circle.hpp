#pragma once

namespace gelight {

/// A circle in an image, in pixels.
struct Circle {
  double x = 0, y = 0;  ///< its centre
  double radius = 0;
};

}  // namespace gelight
