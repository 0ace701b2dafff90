#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "gelight/light/traced/philox.hpp"

// Random numbers by name: the same for a seed, a number and a name, whoever asks, in whatever
// order.

/// What is drawn. A new one goes to the end, so that the others stay as they are.
enum class Drawn : std::uint32_t {
  sensor,
  object,
  size,
  column,
  row,
  spin,
  lean,
  lean_way,
  depth,
  shift_x,
  shift_y,
  modulus,
  brightness,  // and of the second light, the third, the fourth
  brightness_2,
  brightness_3,
  brightness_4,
  ambient,
  diffuse,
  specular,
  shininess,
  smoothing,
};

/// The random numbers of a sample, or of a sensor as it was built.
class Draws {
 public:
  enum class Of : std::uint64_t { sample = 0, sensor = std::uint64_t{1} << 63 };

  Draws(std::uint64_t seed, Of of, std::uint64_t number)
      : seed_(seed), path_(static_cast<std::uint64_t>(of) + number) {}

  /// Two numbers within (0, 1); others at each attempt.
  [[nodiscard]] std::array<double, 2> uniforms(Drawn what, std::uint32_t attempt = 0) const {
    const auto four =
        gelight::detail::uniforms(seed_, path_, static_cast<std::uint32_t>(what) + (attempt << 8));
    return {four[0], four[1]};
  }

 private:
  std::uint64_t seed_, path_;
};

/// How a quantity is spread.
struct Distribution {
  enum class Kind { constant, uniform, log_uniform, normal, one_of };
  Kind kind = Kind::constant;
  double low = 0, high = 0;     ///< the ends; all that a constant is, is `low`
  double mean = 0, spread = 0;  ///< of the normal distribution, which is cut off at the ends
  std::vector<double> choices;  ///< each as likely as the others

  [[nodiscard]] double draw(const Draws& draws, Drawn what, std::uint32_t attempt = 0) const {
    const auto u = draws.uniforms(what, attempt);
    switch (kind) {
      case Kind::uniform:
        return low + u[0] * (high - low);
      case Kind::log_uniform:
        return low * std::exp(u[0] * std::log(high / low));
      case Kind::one_of:
        return choices[static_cast<std::size_t>(u[0] * static_cast<double>(choices.size()))];
      case Kind::normal:
        return draw_normal(draws, what, attempt);
      default:
        return low;
    }
  }

  /// The least and the largest that it can give.
  [[nodiscard]] double least() const {
    return choices.empty() ? low : *std::min_element(choices.begin(), choices.end());
  }
  [[nodiscard]] double most() const {
    if (!choices.empty()) return *std::max_element(choices.begin(), choices.end());
    return kind == Kind::constant ? low : high;
  }

  static constexpr std::uint32_t most_attempts = 1000;

 private:
  // By rejection: of normal numbers those within, or where the ends are nearer than twice the
  // spread, of even ones as many as are likely. Of either at least one of eight is taken.
  [[nodiscard]] double draw_normal(const Draws& draws, Drawn what, std::uint32_t attempt) const {
    const bool is_narrow = high - low < 2 * spread;
    for (std::uint32_t again = 0; again < most_attempts; ++again) {
      const auto u = draws.uniforms(what, attempt + (again << 12));
      if (is_narrow) {
        const double value = low + u[1] * (high - low), z = (value - mean) / spread;
        if (u[0] < std::exp(-z * z / 2)) return value;
        continue;
      }
      const double value =
          mean + spread * std::sqrt(-2 * std::log(u[0])) * std::cos(2 * std::numbers::pi * u[1]);
      if (value >= low && value <= high) return value;
    }
    return mean;  // after a thousand in vain: never
  }
};
