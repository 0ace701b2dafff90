#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

namespace gelight {

/// Number of a vertex, face, half-edge, pixel row or column.
using Index = std::int32_t;

template <class T>
using Vec2 = Eigen::Matrix<T, 2, 1>;
template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

/// Cross product. (Eigen's own needs its Geometry module, which doubles the time to compile.)
template <class T>
[[nodiscard]] Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// What a distance is where no path leads.
template <class T>
inline constexpr T unreachable = std::numeric_limits<T>::infinity();

}  // namespace gelight
