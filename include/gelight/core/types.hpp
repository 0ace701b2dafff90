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

/// What a distance is where no path leads.
template <class T>
inline constexpr T unreachable = std::numeric_limits<T>::infinity();

}  // namespace gelight
