#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "gelight/core/bits.hpp"
#include "gelight/core/types.hpp"

// Normals of a row of pixels, in plain loops over planar arrays that compilers vectorise. The rows
// that are written are restricted, so that compilers know that they do not overlap the others.
namespace gelight::detail {

/// A row of vectors, one plane per coordinate.
template <class T>
struct VectorRow {
  T *x, *y, *z;
};

/// The rays (u, v, 1) of a row of pixels, and one over their lengths.
template <class T>
struct RayRow {
  const T *u, *inverse_length;
  T v;
};

/// 1 / sqrt(x) within 8e-7 of its size in float and 1e-15 in double, by Newton's iteration from a
/// first guess made of the number's bits, its constants chosen so that two steps serve for float.
/// Unlike std::sqrt, which has to set errno, it is vectorised, and unlike processors' own
/// approximations the same everywhere. (Moroz, Walczyk, Hrynchyshyn, Holimath, Cieslinski, Fast
/// calculation of inverse square root with the use of magic constant, 2018,
/// doi:10.1016/j.amc.2017.08.025)
template <class T>
[[nodiscard]] T inverse_sqrt(T x) {
  const T half = x / 2;
  if constexpr (sizeof(T) == 4) {
    T y = detail::bit_cast<T>(0x5f376908 - (detail::bit_cast<std::int32_t>(x) >> 1));
    y *= T(1.50087896) - half * y * y;
    return y * (T(1.50000057) - half * y * y);
  } else {
    T y = detail::bit_cast<T>(0x5fe6eb50c7b537a9 - (detail::bit_cast<std::int64_t>(x) >> 1));
    for (int step = 0; step < 4; ++step) y *= T(1.5) - half * y * y;
    return y;
  }
}

/// Makes the vectors of a row that are not numbers zero.
template <class T>
void clear_unknown(const VectorRow<T>& n, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    if (std::isfinite(n.x[i] + n.y[i] + n.z[i])) continue;
    n.x[i] = n.y[i] = n.z[i] = 0;
  }
}

/// For a row of pixels a multiple of the normal towards the camera, from the depths of the row and
/// its two neighbours, which reach one pixel further on each side: x, y, and its product with the
/// pixel's ray. It is the cross product of the point cloud's Sobel derivatives, a polynomial in the
/// depths of the 3 x 3 window.
///
/// With r = (u, v, 1) the pixel's ray, the two derivatives are D r + (S / fx, A / fy, 0) and
/// E r + (A / fx, R / fy, 0): D and E are the depth's own derivatives, S and R its sums over the
/// two outer columns and the two outer rows, A its mixed difference. What is common to both drops
/// out of the product, so that nothing cancels where the surface is flat. `sum` and `difference`
/// are used on the way: a loop that reads a row at three places in a row is not vectorised by all.
template <class T>
void sobel_product_row(T* __restrict x, T* __restrict y, T* __restrict along_ray, T* __restrict sum,
                       T* __restrict difference, const T* above, const T* middle, const T* below,
                       T fx, T fy, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    sum[i] = 2 * (above[i] + below[i]);
    difference[i] = 2 * (below[i] - above[i]);
  }
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T top_difference = above[i + 1] - above[i - 1], top_sum = above[i + 1] + above[i - 1];
    const T low_difference = below[i + 1] - below[i - 1], low_sum = below[i + 1] + below[i - 1];
    const T D = top_difference + 2 * (middle[i + 1] - middle[i - 1]) + low_difference;
    const T S = top_sum + 2 * (middle[i + 1] + middle[i - 1]) + low_sum;
    const T E = (low_sum - top_sum) + difference[i];
    const T R = (low_sum + top_sum) + sum[i];
    const T A = low_difference - top_difference;
    x[i] = fx * (D * R - E * A);
    y[i] = fy * (E * S - D * A);
    along_ray[i] = A * A - S * R;
  }
}

/// Unit normals out of what sobel_product_row makes; z holds the products with the rays.
template <class T>
void unit_normal_row(T* __restrict x, T* __restrict y, T* __restrict z, const RayRow<T>& ray,
                     std::ptrdiff_t count) {
  const T* const u = ray.u;
  const T v = ray.v;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T nz = z[i] - u[i] * x[i] - v * y[i];
    const T scale = inverse_sqrt(x[i] * x[i] + y[i] * y[i] + nz * nz);
    x[i] *= scale;
    y[i] *= scale;
    z[i] = scale * nz;
  }
}

/// The same as unit_normal_row, but with z the cosine to the ray, and x and y those of the normal
/// without its part along the ray: what Phong's equation needs, see phong_row.hpp.
template <class T>
void unit_facet_row(T* __restrict x, T* __restrict y, T* __restrict z, const RayRow<T>& ray,
                    std::ptrdiff_t count) {
  const T *const u = ray.u, *const inverse_length = ray.inverse_length;
  const T v = ray.v;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T nz = z[i] - u[i] * x[i] - v * y[i];
    const T scale = inverse_sqrt(x[i] * x[i] + y[i] * y[i] + nz * nz);
    const T cosine = z[i] * inverse_length[i];
    const T along = cosine * inverse_length[i];
    x[i] = scale * (x[i] - u[i] * along);
    y[i] = scale * (y[i] - v * along);
    z[i] = scale * cosine;
  }
}

/// The unit normal towards the camera from the depths of a 3 x 3 window, row after row, of any
/// size: what the two rows' functions above give, but where their products leave the range of T.
/// Zero where a depth is not finite, or the window's derivatives have no direction.
template <class T>
[[nodiscard]] Vec3<T> sobel_normal(const std::array<T, 9>& window, T fx, T fy, T u, T v) {
  T largest = 0;
  for (const T z : window) {
    if (!std::isfinite(z)) return Vec3<T>(0, 0, 0);
    largest = std::max(largest, std::abs(z));
  }
  // A power of two, which rounds nothing: the normal depends on the depths' proportions alone.
  int exponent = 0;
  std::frexp(largest, &exponent);
  std::array<double, 9> z{};
  for (std::size_t i = 0; i < 9; ++i) {
    z[i] = std::ldexp(static_cast<double>(window[i]), -exponent);
  }
  double x = 0, y = 0, along_ray = 0, sum = 0, difference = 0;
  sobel_product_row(&x, &y, &along_ray, &sum, &difference, &z[1], &z[4], &z[7], double{fx},
                    double{fy}, 1);
  const double nz = along_ray - double{u} * x - double{v} * y;
  return cast<T>(stable_unit(Vec3<double>(x, y, nz)));
}

/// A depth a pixel beyond the image's edge, extrapolated linearly from the two before it, to no
/// less than half of the one at the edge: a steep rim goes on to behind the camera, and only a
/// window of positive depths has a normal that faces the camera.
template <class T>
[[nodiscard]] T beyond_edge(T at_edge, T before) {
  const T z = 2 * at_edge - before;
  return z < at_edge / 2 ? at_edge / 2 : z;  // NaN, where one of them is
}

/// Writes the pixels before and after a row of depths, extrapolated.
template <class T>
void extrapolate_ends(T* row, Index width) {
  row[-1] = width > 1 ? beyond_edge(row[0], row[1]) : row[0];
  row[width] = width > 1 ? beyond_edge(row[width - 1], row[width - 2]) : row[0];
}

/// Writes the row of depths outside the first or the last row, `width` long and one more each side.
template <class T>
void extrapolate_row(T* outside, const T* first, const T* second, Index width) {
  for (Index x = -1; x <= width; ++x) outside[x] = beyond_edge(first[x], second[x]);
}

}  // namespace gelight::detail
