#pragma once

#if !defined(_MSVC_LANG) && __cplusplus < 201709L
#error "gelight needs C++20: compile with -std=c++20"
#endif

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <utility>

#include "gelight/core/tolerance.hpp"

/// Geodesics on triangle meshes, and the images of optical tactile sensors.
namespace gelight {

/// Number of a vertex, face, half-edge, pixel row or column.
using Index = std::int32_t;

/// A pair of numbers: a point or vector of a plane or an image.
template <class T>
using Vec2 = Eigen::Matrix<T, 2, 1>;
/// Three numbers: a point or vector of space.
template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

/// The arithmetic of points and vectors, spelled out: what Eigen's operators compute, but without
/// their expressions, whose types are a good part of what it costs to compile a program.
/// (And by `coeff`: `[]` makes an evaluator for every number, with which programs that are not
/// optimised take twice as long.) Sums go from the first coordinate to the last, whatever the
/// processor and the type. They are apart, so that a program with `using namespace gelight` keeps
/// Eigen's own operators, on which its expressions are built.
namespace detail::arithmetic {

template <std::floating_point T>
[[nodiscard]] Vec2<T> operator+(const Vec2<T>& a, const Vec2<T>& b) {
  return {a.coeff(0) + b.coeff(0), a.coeff(1) + b.coeff(1)};
}
template <std::floating_point T>
[[nodiscard]] Vec2<T> operator-(const Vec2<T>& a, const Vec2<T>& b) {
  return {a.coeff(0) - b.coeff(0), a.coeff(1) - b.coeff(1)};
}
template <std::floating_point T>
[[nodiscard]] Vec2<T> operator-(const Vec2<T>& a) {
  return {-a.coeff(0), -a.coeff(1)};
}
template <std::floating_point T, class S>
requires std::same_as<S, T> || std::integral<S>
[[nodiscard]] Vec2<T> operator*(S s, const Vec2<T>& a) {
  return {static_cast<T>(s) * a.coeff(0), static_cast<T>(s) * a.coeff(1)};
}
template <std::floating_point T, class S>
requires std::same_as<S, T> || std::integral<S>
[[nodiscard]] Vec2<T> operator*(const Vec2<T>& a, S s) {
  return {a.coeff(0) * static_cast<T>(s), a.coeff(1) * static_cast<T>(s)};
}
template <std::floating_point T, class S>
requires std::same_as<S, T> || std::integral<S>
[[nodiscard]] Vec2<T> operator/(const Vec2<T>& a, S s) {
  return {a.coeff(0) / static_cast<T>(s), a.coeff(1) / static_cast<T>(s)};
}
template <std::floating_point T>
[[nodiscard]] Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.coeff(0) + b.coeff(0), a.coeff(1) + b.coeff(1), a.coeff(2) + b.coeff(2)};
}
template <std::floating_point T>
[[nodiscard]] Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.coeff(0) - b.coeff(0), a.coeff(1) - b.coeff(1), a.coeff(2) - b.coeff(2)};
}
template <std::floating_point T>
[[nodiscard]] Vec3<T> operator-(const Vec3<T>& a) {
  return {-a.coeff(0), -a.coeff(1), -a.coeff(2)};
}
template <std::floating_point T, class S>
requires std::same_as<S, T> || std::integral<S>
[[nodiscard]] Vec3<T> operator*(S s, const Vec3<T>& a) {
  return {static_cast<T>(s) * a.coeff(0), static_cast<T>(s) * a.coeff(1),
          static_cast<T>(s) * a.coeff(2)};
}
template <std::floating_point T, class S>
requires std::same_as<S, T> || std::integral<S>
[[nodiscard]] Vec3<T> operator*(const Vec3<T>& a, S s) {
  return {a.coeff(0) * static_cast<T>(s), a.coeff(1) * static_cast<T>(s),
          a.coeff(2) * static_cast<T>(s)};
}
template <std::floating_point T, class S>
requires std::same_as<S, T> || std::integral<S>
[[nodiscard]] Vec3<T> operator/(const Vec3<T>& a, S s) {
  return {a.coeff(0) / static_cast<T>(s), a.coeff(1) / static_cast<T>(s),
          a.coeff(2) / static_cast<T>(s)};
}
template <std::floating_point T>
Vec3<T>& operator+=(Vec3<T>& a, const Vec3<T>& b) {
  for (int i = 0; i < 3; ++i) a.coeffRef(i) += b.coeff(i);
  return a;
}
template <std::floating_point T>
Vec3<T>& operator-=(Vec3<T>& a, const Vec3<T>& b) {
  for (int i = 0; i < 3; ++i) a.coeffRef(i) -= b.coeff(i);
  return a;
}
/// A matrix times a vector.
template <std::floating_point T>
[[nodiscard]] Vec3<T> operator*(const Eigen::Matrix<T, 3, 3>& m, const Vec3<T>& v) {
  Vec3<T> out;
  for (int i = 0; i < 3; ++i)
    out[i] = m(i, 0) * v.coeff(0) + m(i, 1) * v.coeff(1) + m(i, 2) * v.coeff(2);
  return out;
}

}  // namespace detail::arithmetic

namespace detail {
using namespace arithmetic;
}

/// Products and lengths of points and vectors.
///@{
/// Scalar product.
template <std::floating_point T>
[[nodiscard]] T dot(const Vec2<T>& a, const Vec2<T>& b) {
  return a.coeff(0) * b.coeff(0) + a.coeff(1) * b.coeff(1);
}
template <std::floating_point T>
[[nodiscard]] T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.coeff(0) * b.coeff(0) + a.coeff(1) * b.coeff(1) + a.coeff(2) * b.coeff(2);
}
/// Square of the length.
template <std::floating_point T>
[[nodiscard]] T squared_norm(const Vec2<T>& v) {
  return dot(v, v);
}
template <std::floating_point T>
[[nodiscard]] T squared_norm(const Vec3<T>& v) {
  return dot(v, v);
}
/// Length, where its square neither overflows nor underflows.
template <std::floating_point T>
[[nodiscard]] T norm(const Vec2<T>& v) {
  return std::sqrt(dot(v, v));
}
template <std::floating_point T>
[[nodiscard]] T norm(const Vec3<T>& v) {
  return std::sqrt(dot(v, v));
}
/// One unit long; zero stays zero.
template <std::floating_point T>
[[nodiscard]] Vec2<T> normalized(const Vec2<T>& v) {
  using namespace detail::arithmetic;
  const T square = dot(v, v);
  return square > 0 ? v / std::sqrt(square) : v;
}
template <std::floating_point T>
[[nodiscard]] Vec3<T> normalized(const Vec3<T>& v) {
  using namespace detail::arithmetic;
  const T square = dot(v, v);
  return square > 0 ? v / std::sqrt(square) : v;
}
/// In another precision.
template <std::floating_point To, std::floating_point T>
[[nodiscard]] Vec2<To> cast(const Vec2<T>& v) {
  return {static_cast<To>(v.coeff(0)), static_cast<To>(v.coeff(1))};
}
template <std::floating_point To, std::floating_point T>
[[nodiscard]] Vec3<To> cast(const Vec3<T>& v) {
  return {static_cast<To>(v.coeff(0)), static_cast<To>(v.coeff(1)), static_cast<To>(v.coeff(2))};
}
/// The least and the greatest of each coordinate.
template <std::floating_point T>
[[nodiscard]] Vec3<T> least_of(const Vec3<T>& a, const Vec3<T>& b) {
  return {std::min(a.coeff(0), b.coeff(0)), std::min(a.coeff(1), b.coeff(1)),
          std::min(a.coeff(2), b.coeff(2))};
}
template <std::floating_point T>
[[nodiscard]] Vec3<T> greatest_of(const Vec3<T>& a, const Vec3<T>& b) {
  return {std::max(a.coeff(0), b.coeff(0)), std::max(a.coeff(1), b.coeff(1)),
          std::max(a.coeff(2), b.coeff(2))};
}
///@}

/// Cross product. (Eigen's own needs its Geometry module, which doubles the time to compile.)
template <class T>
[[nodiscard]] Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.coeff(1) * b.coeff(2) - a.coeff(2) * b.coeff(1),
          a.coeff(2) * b.coeff(0) - a.coeff(0) * b.coeff(2),
          a.coeff(0) * b.coeff(1) - a.coeff(1) * b.coeff(0)};
}

namespace detail {

template <class V>
using PlainVector = Eigen::Matrix<typename V::Scalar, V::RowsAtCompileTime, 1>;

/// An expression of Eigen that is a point or a vector of so many floating point numbers, and one of
/// the same kind.
template <class V, int size>
concept VectorExpression = std::floating_point<typename V::Scalar> && V::ColsAtCompileTime == 1 &&
                           V::RowsAtCompileTime == size;
template <class V>
concept PlaneOrSpace = VectorExpression<V, 2> || VectorExpression<V, 3>;
template <class W, class V>
concept SameKind = std::same_as<PlainVector<W>, PlainVector<V>>;

}  // namespace detail

/// The same of expressions, which are worked out first.
///@{
template <detail::PlaneOrSpace A, detail::SameKind<A> B>
[[nodiscard]] typename A::Scalar dot(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return dot(detail::PlainVector<A>(a), detail::PlainVector<B>(b));
}
template <detail::VectorExpression<3> A, detail::SameKind<A> B>
[[nodiscard]] detail::PlainVector<A> cross(const Eigen::MatrixBase<A>& a,
                                           const Eigen::MatrixBase<B>& b) {
  return cross(detail::PlainVector<A>(a), detail::PlainVector<B>(b));
}
template <std::floating_point To, detail::PlaneOrSpace V>
[[nodiscard]] auto cast(const Eigen::MatrixBase<V>& v) {
  return cast<To>(detail::PlainVector<V>(v));
}
template <detail::PlaneOrSpace V>
[[nodiscard]] typename V::Scalar squared_norm(const Eigen::MatrixBase<V>& v) {
  return squared_norm(detail::PlainVector<V>(v));
}
template <detail::PlaneOrSpace V>
[[nodiscard]] typename V::Scalar norm(const Eigen::MatrixBase<V>& v) {
  return norm(detail::PlainVector<V>(v));
}
template <detail::PlaneOrSpace V>
[[nodiscard]] detail::PlainVector<V> normalized(const Eigen::MatrixBase<V>& v) {
  return normalized(detail::PlainVector<V>(v));
}
///@}

/// What a distance is where no path leads.
template <class T>
inline constexpr T unreachable = std::numeric_limits<T>::infinity();

namespace detail {

/// The largest number that T holds, or double where that holds less.
template <std::floating_point T>
inline constexpr double largest_number = static_cast<double>(
    std::min<long double>(std::numeric_limits<T>::max(), std::numeric_limits<double>::max()));

template <class Type, class T>
struct DeferredType {
  using Is = Type;
};
/// A type as it is, but named by way of a template's parameter: what a template does with it is
/// looked at when that is compiled, and costs nothing to include.
template <class Type, class T>
using Deferred = typename DeferredType<Type, T>::Is;

/// What allFinite of Eigen tells, without the expressions that make it slow to compile.
template <class V>
[[nodiscard]] bool is_finite(const V& v) {
  for (int i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v.coeff(i))) return false;
  }
  return true;
}

/// The largest amount among the coordinates; zero of no coordinates.
template <class V>
[[nodiscard]] typename V::Scalar largest_part(const V& v) {
  typename V::Scalar largest = 0;
  for (int i = 0; i < v.size(); ++i) largest = std::max(largest, std::abs(v.coeff(i)));
  return largest;
}

template <class V>
[[nodiscard]] typename V::Scalar sum_of_squares(const V& v) {
  typename V::Scalar sum = 0;
  for (int i = 0, size = static_cast<int>(v.size()); i < size; ++i) sum += v.coeff(i) * v.coeff(i);
  return sum;
}

// Whether a sum of squares lost nothing to overflow or underflow.
template <class T>
[[nodiscard]] bool is_safe_square(T sum) {
  constexpr T eps = std::numeric_limits<T>::epsilon();
  return sum > std::numeric_limits<T>::min() / (eps * eps) && sum <= std::numeric_limits<T>::max();
}

// The vector times a power of two that makes its squares safe, and the exponent; zero and what is
// not finite stay as they are.
template <class V>
[[nodiscard]] std::pair<V, int> scaled(V v) {
  const typename V::Scalar largest = largest_part(v);
  if (!(largest > 0 && std::isfinite(largest))) return {v, 0};
  const int exponent = -std::ilogb(largest);
  for (int i = 0; i < v.size(); ++i) v.coeffRef(i) = std::ldexp(v.coeff(i), exponent);
  return {v, exponent};
}

/// Length of a short vector, from the least number that there is to the largest. (Eigen's
/// stableNorm is written for long vectors: slower, and half a second to compile.)
template <class V>
[[nodiscard]] typename V::Scalar stable_norm(const Eigen::MatrixBase<V>& vector) {
  const PlainVector<V> v = vector;
  const auto sum = sum_of_squares(v);
  if (is_safe_square(sum)) return std::sqrt(sum);
  const auto [safe, exponent] = scaled(v);
  return std::ldexp(std::sqrt(sum_of_squares(safe)), -exponent);
}

/// A short vector made one unit long; zero stays zero.
template <class V>
[[nodiscard]] PlainVector<V> stable_unit(const Eigen::MatrixBase<V>& vector) {
  PlainVector<V> v = vector;
  if (!is_safe_square(sum_of_squares(v))) v = scaled(v).first;
  const auto norm = std::sqrt(sum_of_squares(v));
  for (int i = 0; norm != 0 && i < v.size(); ++i) v.coeffRef(i) /= norm;
  return v;
}

/// A unit vector at a right angle to one that is not zero.
template <class T>
[[nodiscard]] Vec3<T> unit_orthogonal(const Vec3<T>& v) {
  // Across the axis that the vector is farthest from.
  int axis = 0;
  for (int i = 1; i < 3; ++i) axis = std::abs(v.coeff(i)) < std::abs(v.coeff(axis)) ? i : axis;
  return stable_unit(cross<T>(stable_unit(v), Vec3<T>(axis == 0, axis == 1, axis == 2)));
}

}  // namespace detail
}  // namespace gelight
