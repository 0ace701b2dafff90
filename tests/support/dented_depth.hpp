#pragma once

#include <algorithm>
#include <cmath>

#include "gelight/views/image_view.hpp"

// Depth images that the tests of smoothing and of membranes share.
namespace gelight {

inline Image<double> flat(Index width, Index height, double depth) {
  return {width, height, depth};
}

inline Image<double> dent(Index width, Index height, double depth) {
  Image<double> contact = flat(width, height, 0.03);
  for (Index y = height / 2 - 3; y <= height / 2 + 3; ++y) {
    for (Index x = width / 2 - 3; x <= width / 2 + 3; ++x) contact(x, y) -= depth;
  }
  return contact;
}

inline double worst_difference(const auto& a, const auto& b) {
  double worst = 0;
  for (Index y = 0; y < a.height(); ++y) {
    for (Index x = 0; x < a.width(); ++x) {
      worst = std::max(worst, std::abs(double{a(x, y)} - double{b(x, y)}));
    }
  }
  return worst;
}

}  // namespace gelight
