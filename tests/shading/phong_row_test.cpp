#include "gelight/shading/phong_row.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gelight/image/normal_rows.hpp"
#include "support/approx.hpp"

using namespace gelight::detail;

TEST_CASE("integer powers: every base-16 digit in every place") {
  const std::vector<double> bases{0, 0.5, 0.9, 0.999, 1, -0.75};
  for (const unsigned exponent :
       {0u, 1u, 2u, 15u, 16u, 17u, 31u, 100u, 255u, 256u, 1000u, 4096u, 70000u}) {
    std::vector<double> base = bases, power(bases.size());
    integer_power_row(power.data(), base.data(), exponent, std::ssize(power));
    for (std::size_t i = 0; i < bases.size(); ++i) {
      const double want = std::pow(bases[i], exponent);
      CHECK(std::abs(power[i] - want) <= 1e-16 * (2.0 * exponent + 1) * std::abs(want));
    }
  }
}

TEST_CASE("real powers in float keep to their bound, for every exponent and base") {
  for (const double exponent : {0.3, 0.5, 1.5, 12.5, 99.9, 1000.1, 30000.5}) {
    const auto e = static_cast<float>(exponent);
    const double least =
        std::pow(double{std::numeric_limits<float>::min()}, 1 / std::max(1.0, exponent));
    std::vector<float> base;
    for (int i = 0; i <= 20000; ++i)
      base.push_back(static_cast<float>(least + (1 - least) * i / 20000));
    std::vector<float> power(base.size());
    real_power_row(power.data(), base.data(), e, std::ssize(power));
    double worst = 0;
    for (std::size_t i = 0; i < base.size(); ++i) {
      const double want = std::pow(double{base[i]}, double{e});
      if (want < double{std::numeric_limits<float>::min()}) continue;
      worst = std::max(worst, std::abs(power[i] / want - 1) / (1 - std::log2(want)));
    }
    CHECK(worst < 3e-7);
  }
  std::vector<float> zero{0, 1}, power(2);
  real_power_row(power.data(), zero.data(), 2.5f, 2);
  CHECK(power[0] == 0);
  CHECK(power[1] == 1);
  // A direction to a light may be a little longer than 1: its highlight is no darker for that.
  std::vector<float> above{1.0001f, 1.001f, 1.0049f}, powers(3);
  for (const float exponent :
       {2.5f, 17000.5f, 17900.5f, 40000.5f, 2e5f + 0.5f, 8e6f + 0.5f, 4e9f}) {
    CAPTURE(exponent);
    real_power_row(powers.data(), above.data(), exponent, 3);
    for (std::size_t i = 0; i < 3; ++i) {
      const double want = std::min(std::pow(double{above[i]}, double{exponent}), 0x1p127);
      CHECK(powers[i] == gelight::test::approx(want).epsilon(1e-4));
    }
  }
}

TEST_CASE("the inverse square root keeps to its bound") {
  double worst = 0, worst_double = 0;
  for (int i = -60; i <= 60; ++i) {
    for (int k = 0; k < 1000; ++k) {
      const double x = std::ldexp(1 + k / 1000.0, i);
      const auto narrow = static_cast<float>(x);
      worst = std::max(worst, std::abs(inverse_sqrt(narrow) * std::sqrt(double{narrow}) - 1));
      const long double exact = 1 / std::sqrt(static_cast<long double>(x));
      worst_double =
          std::max(worst_double, static_cast<double>(std::abs(inverse_sqrt(x) / exact - 1)));
    }
  }
  CHECK(worst < 8e-7);
  CHECK(worst_double < 1e-15);
}
