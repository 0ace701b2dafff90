#include "gelight/core/error.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

using namespace gelight;

TEST_CASE("words and numbers are joined, also where they are of one kind or none") {
  CHECK(detail::joined() == "");
  CHECK(detail::joined("vertex ", 7, " of ", std::size_t{9}, ' ', std::string("x")) ==
        "vertex 7 of 9 x");
  CHECK(detail::joined(-1, 2L, 0.5F) == "-120.5");
}

TEST_CASE("numbers have no more digits than tell them from their neighbours") {
  CHECK(detail::joined(0.1, ' ', 0.1F, ' ', 1e-9, ' ', 0.1 + 0.2) ==
        "0.1 0.1 1e-09 0.30000000000000004");
  CHECK(detail::joined(-std::numeric_limits<double>::infinity(), ' ', 4294967296.0) ==
        "-inf 4294967296");
  CHECK(detail::joined(std::numeric_limits<double>::quiet_NaN()) == "nan");
  std::mt19937_64 random(7);
  for (int i = 0; i < 10000; ++i) {  // every bit pattern comes back
    const double number = std::bit_cast<double>(random());
    const float single = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isfinite(number) || !std::isfinite(single)) continue;
    CHECK(std::strtod(detail::joined(number).c_str(), nullptr) == number);
    CHECK(std::strtof(detail::joined(single).c_str(), nullptr) == single);
  }
}

TEST_CASE("two digits of a number, whatever its size") {
  CHECK(detail::two_digits(0.012345) == "0.012");
  CHECK(detail::two_digits(-1.96e-17) == "-2e-17");
  CHECK(detail::two_digits(0) == "0");
  CHECK(detail::two_digits(std::numeric_limits<double>::infinity()) == "inf");
}
