#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <optional>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/smooth/fans.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Normals of a surface of which the vertices are known, each from a polynomial fitted to the
/// heights of the vertices around, over the plane of the mean normal (F. Cazals, M. Pouget,
/// "Estimating differential quantities using polynomial fitting of osculating jets", 2005,
/// doi:10.1016/j.cagd.2004.09.004). Creases and borders are not crossed.
template <std::floating_point Real>
class FittedNormals {
 public:
  explicit FittedNormals(const Fans<Real>& fans) : fans_(fans) {
    seen_.assign(static_cast<std::size_t>(fans.count()), -1);
  }

  /// Unit normal of a fan; zero where no face of it has an area.
  [[nodiscard]] Vec3<Real> normal(Index fan) {
    Vec3<Real> mean = fans_.mean_normal(fan);
    if (mean.isZero(0)) return mean;
    gather(fan);
    for (int degree = 4; degree >= 2; --degree) {
      if (const auto normal = fit(fan, mean, degree)) return *normal;
    }
    return mean;
  }

 private:
  using Mesh = Surface<Real>;
  static constexpr int most_terms = 14, rings = 3;
  using Sums = Eigen::Matrix<Real, most_terms + 1, most_terms + 1>;
  using Row = Eigen::Matrix<Real, most_terms + 1, 1>;
  // Of the points in the first rings so many a term are taken at least.
  static constexpr int points_per_term = 2;
  // A pivot of less than this share of its column's square is one that the points do not tell.
  static constexpr Real least_pivot = 1e-9;

  static constexpr int terms_of(int degree) { return degree * (degree + 3) / 2; }

  // Fans of the vertices around, ring by ring.
  void gather(Index fan) {
    near_.assign(1, fan);
    ring_end_.assign(1, 1);
    seen_[fan] = fan;
    std::ptrdiff_t i = 0;
    for (int ring = 0; ring < rings; ++ring) {
      for (const std::ptrdiff_t end = std::ssize(near_); i < end; ++i) {
        for (const Index h : fans_.corners(near_[i])) {
          for (const Index other : {Mesh::next(h), Mesh::previous(h)}) {
            const Index next = fans_.at(other);
            if (seen_[next] == fan) continue;
            seen_[next] = fan;
            near_.push_back(next);
          }
        }
      }
      ring_end_.push_back(std::ssize(near_));
    }
  }

  // Least squares with weights that fall with the distance, by normal equations: they are of few
  // unknowns that are all about one large.
  [[nodiscard]] std::optional<Vec3<Real>> fit(Index fan, const Vec3<Real>& mean, int degree) const {
    const int terms = terms_of(degree);
    std::size_t ring = static_cast<std::size_t>(degree) - 1;
    while (ring < rings && ring_end_[ring] - 1 < std::ptrdiff_t{points_per_term} * terms) ++ring;
    const std::ptrdiff_t count = ring_end_[ring];
    if (count - 1 < terms + terms / 4) return {};

    const Vec3<Real>& centre = fans_.surface().position(fans_.vertex(fan));
    const Vec3<Real> x = unit_orthogonal(mean), y = cross(mean, x);
    Real size = 0;
    for (std::ptrdiff_t i = 1; i < count; ++i)
      size = std::max(size, stable_norm(offset(i, centre)));
    Sums sums = Sums::Zero();
    Row row = Row::Zero(), weighted;
    for (std::ptrdiff_t i = 1; i < count; ++i) {
      const Vec3<Real> p = offset(i, centre) / size;
      const Real u = dot(p, x), v = dot(p, y);
      row[0] = u;
      row[1] = v;
      for (int k = 2, d = 2; d <= degree; ++d) {
        // Those of the degree before, times u or v.
        row[k] = row[k - d] * u;
        for (const int end = k++ + d; k <= end; ++k) row[k] = row[k - d - 1] * v;
      }
      row[terms] = dot(p, mean);
      weighted = (1 / (Real(0.02) + squared_norm(p))) * row;
      for (int b = 0; b <= terms; ++b) {
        const int below = terms + 1 - b;
        sums.col(b).segment(b, below) += weighted.segment(b, below) * row[b];
      }
    }
    const auto slope = solve(sums, terms);
    if (!slope) return {};
    return stable_unit(Vec3<Real>(mean - (*slope)[0] * x - (*slope)[1] * y));
  }

  // Cholesky in place, of the lower triangle whose last row is the right side.
  [[nodiscard]] static std::optional<Vec2<Real>> solve(Sums& a, int terms) {
    for (int j = 0; j < terms; ++j) {
      const Real whole = a(j, j);
      for (int k = 0; k < j; ++k) a(j, j) -= a(j, k) * a(j, k);
      if (!(a(j, j) > least_pivot * whole)) return {};
      a(j, j) = std::sqrt(a(j, j));
      for (int i = j + 1; i <= terms; ++i) {
        for (int k = 0; k < j; ++k) a(i, j) -= a(i, k) * a(j, k);
        a(i, j) /= a(j, j);
      }
    }
    // Back from the last unknown to the first two, the slopes.
    for (int j = terms - 1; j >= 0; --j) {
      Real sum = a(terms, j);
      for (int i = j + 1; i < terms; ++i) sum -= a(i, j) * a(terms, i);
      a(terms, j) = sum / a(j, j);
    }
    return Vec2<Real>(a(terms, 0), a(terms, 1));
  }

  [[nodiscard]] Vec3<Real> offset(std::ptrdiff_t i, const Vec3<Real>& centre) const {
    return fans_.surface().position(fans_.vertex(near_[i])) - centre;
  }

  const Fans<Real>& fans_;
  Array<Index> seen_;  // of each fan: the one it was gathered for last
  Array<Index> near_;
  Array<std::ptrdiff_t> ring_end_;
};

}  // namespace gelight::detail
