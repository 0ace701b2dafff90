#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "gelight/core/types.hpp"

// Normals of a row of pixels, in plain loops over planar arrays that compilers vectorise.
namespace gelight::detail {

/// A row of vectors, one plane per coordinate; `facing` is their product with the pixel's ray.
template <class T>
struct NormalRow {
  T *x, *y, *z, *facing;
};

/// The rays (u, v, 1) of a row of pixels, and the focal lengths in pixels.
template <class T>
struct RayRow {
  const T* u;
  T v, fx, fy;
};

/// 1 / sqrt(x) within two units in the last place, by Newton's iteration from a first guess made
/// of the number's bits. Unlike std::sqrt, which has to set errno, it is vectorised, and unlike
/// processors' own approximations the same everywhere. (McEniry, The mathematics behind the fast
/// inverse square root function code, 2007)
template <class T>
[[nodiscard]] T inverse_sqrt(T x) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
  constexpr Bits magic =
      sizeof(T) == 4 ? static_cast<Bits>(0x5f375a86) : static_cast<Bits>(0x5fe6eb50c7b537a9);
  T y = std::bit_cast<T>(static_cast<Bits>(magic - (std::bit_cast<Bits>(x) >> 1)));
  const T half = x / 2;
  constexpr int steps = sizeof(T) == 4 ? 3 : 4;  // each squares the first guess's error of 3 %
  for (int step = 0; step < steps; ++step) y *= T(1.5) - half * y * y;
  return y;
}

/// Makes the vectors of a row that are not numbers zero.
template <class T>
void clear_unknown(const NormalRow<T>& n, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    if (std::isfinite(n.x[i] + n.y[i] + n.z[i] + n.facing[i])) continue;
    n.x[i] = n.y[i] = n.z[i] = n.facing[i] = 0;
  }
}

/// The unit normals of a row of pixels towards the camera, from the depths of the row and its two
/// neighbours, which reach one pixel further on each side: the cross product of the point cloud's
/// Sobel derivatives, which is a polynomial in the depths of the 3 x 3 window.
///
/// With r = (u, v, 1) the pixel's ray, the two derivatives are D r + (S / fx, A / fy, 0) and
/// E r + (A / fx, R / fy, 0): D and E are the depth's own derivatives, S and R its sums over the
/// two outer columns and the two outer rows, A its mixed difference. What is common to both drops
/// out of the product, so that nothing cancels where the surface is flat. The rows that are written
/// are restricted, so that compilers know that they do not overlap the others, and vectorise.
template <class T>
void sobel_normals_of(T* __restrict nx, T* __restrict ny, T* __restrict nz, T* __restrict facing,
                      const T* above, const T* middle, const T* below, const RayRow<T>& ray,
                      std::ptrdiff_t count) {
  const T* const u = ray.u;
  const T v = ray.v, fx = ray.fx, fy = ray.fy;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T top_difference = above[i + 1] - above[i - 1], top_sum = above[i + 1] + above[i - 1];
    const T difference = middle[i + 1] - middle[i - 1], sum = middle[i + 1] + middle[i - 1];
    const T low_difference = below[i + 1] - below[i - 1], low_sum = below[i + 1] + below[i - 1];
    const T D = top_difference + 2 * difference + low_difference;
    const T E = (low_sum - top_sum) + 2 * (below[i] - above[i]);
    const T S = top_sum + 2 * sum + low_sum;
    const T R = top_sum + low_sum + 2 * (above[i] + below[i]);
    const T A = low_difference - top_difference;
    const T x = fx * (D * R - E * A);
    const T y = fy * (E * S - D * A);
    const T along_ray = A * A - S * R;
    const T z = along_ray - u[i] * x - v * y;
    const T scale = inverse_sqrt(x * x + y * y + z * z);
    nx[i] = scale * x;
    ny[i] = scale * y;
    nz[i] = scale * z;
    facing[i] = scale * along_ray;
  }
}

template <class T>
void sobel_normal_row(const NormalRow<T>& n, const T* above, const T* middle, const T* below,
                      const RayRow<T>& ray, std::ptrdiff_t count) {
  sobel_normals_of(n.x, n.y, n.z, n.facing, above, middle, below, ray, count);
}

/// Writes the pixels before and after a row of depths, extrapolated linearly.
template <class T>
void extrapolate_ends(T* row, Index width) {
  row[-1] = width > 1 ? 2 * row[0] - row[1] : row[0];
  row[width] = width > 1 ? 2 * row[width - 1] - row[width - 2] : row[0];
}

/// Writes the row of depths outside the first or the last row, `width` long and one more each side.
template <class T>
void extrapolate_row(T* outside, const T* first, const T* second, Index width) {
  for (Index x = -1; x <= width; ++x) outside[x] = 2 * first[x] - second[x];
}

}  // namespace gelight::detail
