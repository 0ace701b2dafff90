#pragma once

#include <array>
#include <cmath>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

namespace gelight {

/// Where a rigid body is: a point p of it is seen at rotation p + translation, in the camera's
/// frame. An `Eigen::Isometry3d` or another of Eigen's transforms converts to it.
struct Pose {
  /// Or any other linear map, such as one with a size, which is then drawn as it is: nothing checks
  /// that it keeps lengths.
  Eigen::Matrix3d rotation{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3<double> translation{0, 0, 0};  ///< in the unit of the mesh

  Pose() = default;
  /// Of the two.
  Pose(const Eigen::Matrix3d& turned, const Vec3<double>& moved)
      : rotation(turned), translation(moved) {}
  /// Of what has a linear part and a translation.
  template <class Transform>
  requires requires(const Transform& t) {
    t.linear();
    t.translation();
  }
  Pose(const Transform& transform)
      : rotation(transform.linear().template cast<double>()),
        translation(transform.translation().template cast<double>()) {}

  /// Where a point of the body is.
  [[nodiscard]] Vec3<double> operator()(const Vec3<double>& p) const {
    const auto [x, y, z] = moved(p[0], p[1], p[2]);
    return {x, y, z};
  }
  /// The same of its coordinates, or those of several points, in lanes.
  template <class Number>
  [[nodiscard, gnu::always_inline]] inline std::array<Number, 3> moved(const Number& x,
                                                                       const Number& y,
                                                                       const Number& z) const {
    // Spelled out, with sums in Eigen's order: its product takes long to compile.
    const auto r = [this](Index i, Index j) { return rotation.coeff(i, j); };
    const auto t = [this](Index i) { return translation.coeff(i); };
    return {r(0, 0) * x + r(0, 1) * y + r(0, 2) * z + t(0),
            r(1, 0) * x + r(1, 1) * y + r(1, 2) * z + t(1),
            r(2, 0) * x + (r(2, 1) * y + r(2, 2) * z) + t(2)};
  }

  /// Throws InvalidInput for a number that is not finite.
  void require_valid() const {
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 3; ++j) {
        detail::require(std::isfinite(rotation(i, j)), "the pose's rotation (", i, ", ", j, ") is ",
                        rotation(i, j), ", not finite");
      }
    }
    detail::require(std::isfinite(translation[0]) && std::isfinite(translation[1]) &&
                        std::isfinite(translation[2]),
                    "the pose's translation (", translation[0], ", ", translation[1], ", ",
                    translation[2], ") is not finite");
  }
};

}  // namespace gelight
