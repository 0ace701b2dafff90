#include "gelight/core/error.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <limits>
#include <string>

using namespace gelight;

TEST_CASE("words and numbers are joined, also where they are of one kind or none") {
  CHECK(detail::joined() == "");
  CHECK(detail::joined("vertex ", 7, " of ", std::size_t{9}, ' ', std::string("x")) ==
        "vertex 7 of 9 x");
  CHECK(detail::joined(-1, 2L, 0.5F) == "-120.5");
}

TEST_CASE("two digits of a number, whatever its size") {
  CHECK(detail::two_digits(0.012345) == "0.012");
  CHECK(detail::two_digits(-1.96e-17) == "-2e-17");
  CHECK(detail::two_digits(0) == "0");
  CHECK(detail::two_digits(std::numeric_limits<double>::infinity()) == "inf");
}
