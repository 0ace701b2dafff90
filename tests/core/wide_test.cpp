#include "gelight/core/wide.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <random>
#include <vector>

namespace {

// What a fused multiply-add would round once instead of twice.
template <class T>
void add_products(std::vector<T>& out, const std::vector<T>& a, const std::vector<T>& b) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] * b[i] + out[i];
}

}  // namespace

TEST_CASE_TEMPLATE("rows have the same bits whatever registers they are computed in", T, float,
                   double) {
  std::mt19937 random(1);
  std::uniform_real_distribution<T> uniform(-1, 1);
  for (const std::size_t size : {1U, 7U, 16U, 33U, 1000U}) {
    std::vector<T> a(size), b(size), wide(size);
    for (std::size_t i = 0; i < size; ++i) {
      a[i] = uniform(random);
      b[i] = uniform(random);
      wide[i] = -a[i] * b[i];  // the sum is what rounding left of the product
    }
    const std::vector<T> start = wide;
    gelight::detail::vectorised([&] { add_products(wide, a, b); });
    for (std::size_t i = 0; i < size; ++i) {
      volatile const T product = a[i] * b[i];  // rounded before it is added
      CHECK(wide[i] == product + start[i]);
    }
  }
}
