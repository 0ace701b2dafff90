#pragma once

#include <doctest/doctest.h>

namespace gelight::test {

/// A number but for a share of it, `.epsilon(share)`. (doctest's own allows that share of 1 as
/// well, which is more than all of a small number.) `.scale(unit)` allows a share of some unit
/// besides; the smallest one, without which 0 would not be 0, means nothing.
[[nodiscard]] inline doctest::Approx approx(double value) {
  return doctest::Approx(value).scale(1e-300);
}

}  // namespace gelight::test
