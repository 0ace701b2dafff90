#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/shading/phong.hpp"

// Phong's equation for a row of pixels, in plain loops over planar arrays that compilers vectorise.
namespace gelight::detail {

/// power[i] *= base[i]^Digit, then base[i] = base[i]^16 unless this is the last digit.
template <int Digit, class T>
void multiply_power(T* __restrict power, T* __restrict base, std::ptrdiff_t count, bool last) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T b1 = base[i], b2 = b1 * b1, b4 = b2 * b2, b8 = b4 * b4;
    T factor = 1;
    if constexpr (Digit & 1) factor *= b1;
    if constexpr (Digit & 2) factor *= b2;
    if constexpr (Digit & 4) factor *= b4;
    if constexpr (Digit & 8) factor *= b8;
    power[i] *= factor;
  }
  if (last) return;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T b2 = base[i] * base[i], b4 = b2 * b2, b8 = b4 * b4;
    base[i] = b8 * b8;
  }
}

/// power[i] = base[i]^exponent by repeated squaring; overwrites `base`. The exponent's base-16
/// digits are constants of the loops.
template <class T>
void integer_power_row(T* __restrict power, T* __restrict base, unsigned exponent,
                       std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) power[i] = 1;
  for (; exponent > 0; exponent /= 16) {
    const bool last = exponent < 16;
    [&]<int... digit>(std::integer_sequence<int, digit...>) {
      ((exponent % 16 == digit ? multiply_power<digit>(power, base, count, last) : void()), ...);
    }
    (std::make_integer_sequence<int, 16>());
  }
}

/// A light along a row: the direction to it, in planes.
template <class T>
struct LightRow {
  const T *x, *y, *z;
};

/// What a light adds to the three channels of the image.
template <class T>
struct LightColour {
  std::array<T, 3> diffuse, specular;
  T shininess;
  Specular form;
};

template <class T>
struct RgbRow {
  T *r, *g, *b;
};

/// toward[i] = max(0, N.L); mirrored[i] = R.V, and at least 0 in the gated form.
template <class T>
void reflect_row(T* __restrict toward, T* __restrict mirrored, const NormalRow<T>& n,
                 const LightRow<T>& light, const T* __restrict u, T v,
                 const T* __restrict inverse_ray, T least, std::ptrdiff_t count) {
  const T* __restrict nx = n.x, * __restrict ny = n.y, * __restrict nz = n.z, * __restrict facing = n.facing;
  const T* __restrict lx = light.x, * __restrict ly = light.y, * __restrict lz = light.z;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T cosine = nx[i] * lx[i] + ny[i] * ly[i] + nz[i] * lz[i];
    const T lit = cosine > 0 ? cosine : 0;
    const T along_ray = lx[i] * u[i] + ly[i] * v + lz[i];
    // The eye lies in the direction -ray / |ray|.
    const T r_dot_v = inverse_ray[i] * (along_ray - 2 * lit * facing[i]);
    toward[i] = lit;
    mirrored[i] = r_dot_v > least ? r_dot_v : least;
  }
}

/// channel[i] += diffuse toward[i] + specular power[i]; nothing where a gated light is behind.
template <class T>
void add_light_row(T* __restrict channel, const T* __restrict toward, const T* __restrict power,
                   T diffuse, T specular, Specular form, std::ptrdiff_t count) {
  if (form == Specular::gated) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      channel[i] += toward[i] > 0 ? diffuse * toward[i] + specular * power[i] : 0;
    }
  } else {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      channel[i] += diffuse * toward[i] + specular * power[i];
    }
  }
}

/// Adds Phong's two terms of one light to the channels; `scratch` are three rows.
template <class T>
void phong_row(const RgbRow<T>& out, const NormalRow<T>& n, const LightRow<T>& light,
               const LightColour<T>& colour, const T* u, T v, const T* inverse_ray,
               const std::array<T*, 3>& scratch, std::ptrdiff_t count) {
  const auto& [toward, mirrored, power] = scratch;
  const T least = colour.form == Specular::gated ? 0 : -std::numeric_limits<T>::infinity();
  reflect_row(toward, mirrored, n, light, u, v, inverse_ray, least, count);
  const T exponent = colour.shininess;
  if (exponent == std::floor(exponent) && exponent < T(1u << 31)) {
    integer_power_row(power, mirrored, static_cast<unsigned>(exponent), count);
  } else {
    for (std::ptrdiff_t i = 0; i < count; ++i) power[i] = std::pow(mirrored[i], exponent);
  }
  const std::array<T*, 3> channels{out.r, out.g, out.b};
  for (std::size_t c = 0; c < 3; ++c) {
    if (colour.diffuse[c] == 0 && colour.specular[c] == 0) continue;
    add_light_row(channels[c], toward, power, colour.diffuse[c], colour.specular[c], colour.form,
                  count);
  }
}

}  // namespace gelight::detail
