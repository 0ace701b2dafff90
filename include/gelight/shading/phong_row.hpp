#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>

#include "gelight/core/bits.hpp"
#include "gelight/core/types.hpp"
#include "gelight/shading/phong.hpp"

// Phong's equation for a row of pixels, in plain loops over planar arrays that compilers vectorise.
namespace gelight::detail {

/// One base-4 digit of an exponent: power[i] *= base[i]^digit, where power starts as 1, and
/// base[i] = base[i]^4 for the digits still to come.
template <unsigned digit, bool is_first, bool is_last, class T>
void multiply_power(T* __restrict power, T* __restrict base, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T once = base[i], twice = once * once;
    T factor = is_first ? T(1) : power[i];
    if constexpr ((digit & 1) != 0) factor *= once;
    if constexpr ((digit & 2) != 0) factor *= twice;
    power[i] = factor;
    if constexpr (!is_last) base[i] = twice * twice;
  }
}

/// The same for a digit that is not a constant.
template <bool is_first, bool is_last, class T>
void multiply_power(T* power, T* base, unsigned digit, std::ptrdiff_t count) {
  if (digit == 0) return multiply_power<0, is_first, is_last>(power, base, count);
  if (digit == 1) return multiply_power<1, is_first, is_last>(power, base, count);
  if (digit == 2) return multiply_power<2, is_first, is_last>(power, base, count);
  multiply_power<3, is_first, is_last>(power, base, count);
}

/// power[i] = base[i]^exponent by repeated squaring; overwrites `base`.
template <class T>
void integer_power_row(T* power, T* base, unsigned exponent, std::ptrdiff_t count) {
  multiply_power<true, false>(power, base, exponent % 4, count);
  if (exponent < 4) return;
  for (exponent /= 4; exponent >= 4; exponent /= 4) {
    multiply_power<false, false>(power, base, exponent % 4, count);
  }
  multiply_power<false, true>(power, base, exponent, count);
}

/// log2(x) of a positive normal number, within 2e-7 of its size.
[[nodiscard]] inline float fast_log2(float x) {
  // x = 2^e m with m from sqrt(1/2) to sqrt(2).
  const std::int32_t bits = detail::bit_cast<std::int32_t>(x) - 0x3f3504f3;
  const std::int32_t e = bits >> 23;
  const float m = detail::bit_cast<float>((bits & 0x007fffff) + 0x3f3504f3);
  // log(m) = 2 atanh(t), whose series has fallen below 2e-9 of it after five terms.
  const float t = (m - 1) / (m + 1), t2 = t * t;
  const float series = 1 + t2 * (1 / 3.f + t2 * (1 / 5.f + t2 * (1 / 7.f + t2 * (1 / 9.f))));
  return static_cast<float>(e) + 2 * std::numbers::log2e_v<float> * t * series;
}

/// 2^x for x in [-126, 127], within 3e-7 of its size.
[[nodiscard]] inline float fast_exp2(float x) {
  constexpr float shift = 3 << 22;  // adding it leaves the nearest integer in the lowest bits
  const float shifted = x + shift;
  const std::int32_t whole =
      detail::bit_cast<std::int32_t>(shifted) - detail::bit_cast<std::int32_t>(shift);
  // By way of the integer: -ffast-math makes x of shifted - shift.
  const float f = (x - static_cast<float>(whole)) * std::numbers::ln2_v<float>;  // up to 0.35
  const float series =
      1 + f * (1 + f * (1 / 2.f + f * (1 / 6.f + f * (1 / 24.f + f * (1 / 120.f + f / 720.f)))));
  return series * detail::bit_cast<float>((whole + 127) << 23);
}

/// power[i] = base[i]^exponent for bases that are 0 or have a normal number for a power. In float
/// the relative error is below 3e-7 (1 + |log2 power|), and powers beyond 2^127, of bases a little
/// above 1, are 2^127; double is std::pow's.
template <class T>
void real_power_row(T* __restrict power, const T* base, T exponent, std::ptrdiff_t count) {
  if constexpr (std::same_as<T, float>) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const float result = fast_exp2(std::min(exponent * fast_log2(base[i]), 127.f));
      power[i] = base[i] > 0 ? result : 0;
    }
  } else {
    for (std::ptrdiff_t i = 0; i < count; ++i) power[i] = std::pow(base[i], exponent);
  }
}

/// A row of unit normals n in coordinates in which the pixel's ray r = (u, v, 1) is an axis:
///
///     x = nx - u (n.r) / |r|^2,  y = ny - v (n.r) / |r|^2,  z = n.r / |r|.
///
/// With those of a direction l to a light,
///
///     x = lx - u lz,  y = ly - v lz,  z = l.r / |r|,
///
/// n.l is the sum of the three products; and as the eye is in the direction -r / |r|, Phong's other
/// two products are the z of either: three numbers of a light are enough.
template <class T>
struct FacetRow {
  const T *x, *y, *z;
};

/// A row of one coordinate of the directions to a light: least + step code[i]. Floats are kept as
/// codes of 16 bits over the range that they have in the row, as long rows of them take longer to
/// fetch than to work with.
template <class T>
struct CodedRow {
  using Code = std::conditional_t<std::same_as<T, float>, std::uint16_t, T>;
  const Code* code;
  T least, step;
};

/// A row of directions to a light, in the coordinates of FacetRow.
template <class T>
struct LightRow {
  CodedRow<T> x, y, z;
};

/// What a light adds to the three channels of the image.
template <class T>
struct LightColour {
  std::array<T, 3> diffuse, specular;
  T shininess;
  Specular form;
  /// Cosines whose power is not a normal number count as 0: it cannot be seen, and numbers below
  /// the normal ones are slow to work with.
  T least_cosine;
  /// N.L counts for so much less: as much as rounding may leave of a light along the membrane.
  T tangent = 0;
};

/// What Phong's equation makes of a light along a row: max(0, N.L), and R.V raised to the
/// shininess; `mirrored` is used on the way.
template <class T>
struct PhongScratch {
  T *toward, *mirrored, *shine;
};

/// toward[i] = max(0, N.L - tangent); mirrored[i] = R.V, or 0 where that is closer to 0 than
/// `least` or, in the gated form, negative or the light behind the surface.
template <Specular form, class T>
void reflect_row(T* __restrict toward, T* __restrict mirrored, const FacetRow<T>& n,
                 const LightRow<T>& light, T tangent, T least, std::ptrdiff_t count) {
  const T *const nx = n.x, *const ny = n.y, *const nz = n.z;
  const auto [x, y, z] = light;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T lx = x.least + x.step * static_cast<T>(x.code[i]);
    const T ly = y.least + y.step * static_cast<T>(y.code[i]);
    const T lz = z.least + z.step * static_cast<T>(z.code[i]);
    const T cosine = nx[i] * lx + ny[i] * ly + nz[i] * lz;
    const T past = cosine - tangent;
    const T lit = (past + std::abs(past)) / 2;  // exactly max(0, past), and vectorised
    // Mirrored by all of N.L: a high power would make much of what is off it.
    const T facing = form == Specular::gated ? cosine : lit;  // the gate takes what is negative
    const T r_dot_v = lz - 2 * facing * nz[i];
    toward[i] = lit;
    if constexpr (form == Specular::gated) {
      const T in_front = r_dot_v > least ? r_dot_v : 0;
      mirrored[i] = lit > 0 ? in_front : 0;
    } else {
      mirrored[i] = r_dot_v * r_dot_v > least * least ? r_dot_v : 0;
    }
  }
}

/// shine[i] = 0 where the light is behind the surface.
template <class T>
void gate_row(T* __restrict shine, const T* toward, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) shine[i] = toward[i] > 0 ? shine[i] : 0;
}

/// The two factors of a light's diffuse and specular terms along a row.
template <class T>
void phong_row(const PhongScratch<T>& out, const FacetRow<T>& n, const LightRow<T>& light,
               const LightColour<T>& colour, std::ptrdiff_t count) {
  const auto& [toward, mirrored, shine] = out;
  const bool gated = colour.form == Specular::gated;
  if (gated) {
    reflect_row<Specular::gated>(toward, mirrored, n, light, colour.tangent, colour.least_cosine,
                                 count);
  } else {
    reflect_row<Specular::unclamped>(toward, mirrored, n, light, colour.tangent,
                                     colour.least_cosine, count);
  }
  const T exponent = colour.shininess;
  if (exponent == std::floor(exponent) && exponent < T(1u << 31)) {
    integer_power_row(shine, mirrored, static_cast<unsigned>(exponent), count);
  } else {
    real_power_row(shine, mirrored, exponent, count);
  }
  if (gated && exponent == 0) gate_row(shine, toward, count);  // 0^0 = 1
}

/// out[i] = sum[i] and the light, for two rows that do not overlap or are the same.
template <class T>
void add_light_row(T* __restrict out, const T* sum, const PhongScratch<T>& light, T diffuse,
                   T specular, std::ptrdiff_t count) {
  const T *const toward = light.toward, *const shine = light.shine;
  if (sum == out) {
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += diffuse * toward[i] + specular * shine[i];
  } else {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      out[i] = sum[i] + (diffuse * toward[i] + specular * shine[i]);
    }
  }
}

}  // namespace gelight::detail
