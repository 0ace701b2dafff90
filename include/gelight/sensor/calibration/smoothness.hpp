#pragma once

namespace gelight::detail {

/// How a linear model is kept smooth: weights of the squares of its second differences along the
/// normal, for the constant term of the place; a power of `place` more for each degree in it.
struct Smoothness {
  double normal = 1, place = 3;
};

}  // namespace gelight::detail
