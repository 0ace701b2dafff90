#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace gelight::test {

struct Error {
  double mean = 0, max = 0;
};

/// Relative errors where the truth, a function of the vertex, is not zero.
inline Error error_of(const std::vector<double>& d, auto&& truth) {
  Error error;
  double count = 0;
  for (std::size_t v = 0; v < d.size(); ++v) {
    const double t = truth(v);
    if (t == 0) continue;
    const double off = std::abs(d[v] - t) / t;
    error.mean += off;
    error.max = std::max(error.max, off);
    ++count;
  }
  error.mean /= count;
  return error;
}

}  // namespace gelight::test
