#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

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

// In the loops below every array that is written is a restricted parameter: so compilers know that
// the arrays do not overlap, and vectorise.

template <class T>
void squared_length_row(T* __restrict length, const T* x, const T* y, const T* z,
                        std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) length[i] = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
}

template <class T>
void divide_rows(T* __restrict x, T* __restrict y, T* __restrict z, T* __restrict facing,
                 const T* length, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T scale = T(1) / length[i];
    x[i] *= scale;
    y[i] *= scale;
    z[i] *= scale;
    facing[i] *= scale;
  }
}

/// Turns the vectors of a row into unit vectors; what has no length becomes NaN.
template <class T>
void normalise_row(const NormalRow<T>& n, T* length, std::ptrdiff_t count) {
  squared_length_row(length, n.x, n.y, n.z, count);
  // Eigen's square root is vectorised; std::sqrt is not, as it has to set errno.
  Eigen::Map<Eigen::Array<T, Eigen::Dynamic, 1>> squares(length, count);
  squares = squares.sqrt();
  divide_rows(n.x, n.y, n.z, n.facing, length, count);
}

/// Makes the vectors of a row that are not numbers zero.
template <class T>
void clear_unknown(const NormalRow<T>& n, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    if (std::isfinite(n.x[i] + n.y[i] + n.z[i] + n.facing[i])) continue;
    n.x[i] = n.y[i] = n.z[i] = n.facing[i] = 0;
  }
}

/// The cross product of the point cloud's Sobel derivatives along a row, towards the camera, which
/// is a polynomial in the depths of the 3 x 3 window.
///
/// With r = (u, v, 1) the pixel's ray, the two derivatives are D r + (S / fx, A / fy, 0) and
/// E r + (A / fx, R / fy, 0): D and E are the depth's own derivatives, S and R its sums over the
/// two outer columns and the two outer rows, A its mixed difference. What is common to both drops
/// out of the product, so that nothing cancels where the surface is flat. It is taken fx fy times.
template <class T>
void sobel_cross_row(T* __restrict nx, T* __restrict ny, T* __restrict nz, T* __restrict facing,
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
    nx[i] = x;
    ny[i] = y;
    nz[i] = along_ray - u[i] * x - v * y;
    facing[i] = along_ray;
  }
}

/// The unit normals of a row of pixels from the depths of the row and its two neighbours, which
/// reach one pixel further on each side; `length` is scratch.
template <class T>
void sobel_normal_row(const NormalRow<T>& n, T* length, const T* above, const T* middle,
                      const T* below, const RayRow<T>& ray, std::ptrdiff_t count) {
  sobel_cross_row(n.x, n.y, n.z, n.facing, above, middle, below, ray, count);
  normalise_row(n, length, count);
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
