#include "gelight/geodesic/heat/system.hpp"

#include <doctest/doctest.h>

#include <complex>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"

using namespace gelight;

// With the header alone, in which this did not compile for complex numbers.
TEST_CASE_TEMPLATE("a load reaches its connected part, of real and of complex numbers", Number,
                   double, std::complex<double>) {
  const std::vector parts{grid<double>(2, 2), grid<double>(1, 1)};
  const detail::HeatSystem<double> system(Surface(joined(parts)), 1, true);
  detail::Array<Number> load(13, Number(0));
  const auto reached = [&] {
    const detail::Array<char> marks = system.reached_from(load);
    return std::vector<char>(marks.begin(), marks.end());
  };
  CHECK(reached() == std::vector<char>(13, 0));
  load[10] = std::is_same_v<Number, double> ? Number(-1e-300) : std::sqrt(Number(-1));
  std::vector<char> second(13, 0);
  for (std::size_t v = 9; v < 13; ++v) second[v] = 1;
  CHECK(reached() == second);
}
