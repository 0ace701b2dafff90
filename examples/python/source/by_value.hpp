#pragma once

// Plain data as Python pickles and copies it: by value, member by member.

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"

/// What stands for a member in a pickle, and back: itself, where Python knows it.
template <class V>
struct Kept {
  using State = V;
  static State state(const V& value) { return value; }
  static V value(State state) { return state; }
};

/// An image, or a row of numbers, vectors or enumerators, as an array.
template <class P>
struct Kept<Image<P>> {
  using Scalar = typename PixelTraits<P>::Scalar;
  using State = Packed<Scalar>;
  static State state(const Image<P>& image) { return State(array_of(Image<P>(image))); }
  static Image<P> value(const State& array) {
    constexpr bool has_channels = PixelTraits<P>::count > 1;
    gelight::detail::require(array.ndim() == (has_channels ? 3 : 2) &&
                                 (!has_channels || array.shape(2) == PixelTraits<P>::count),
                             "the pickle's image has shape ", shape_text(array));
    Image<P> image(static_cast<Index>(array.shape(1)), static_cast<Index>(array.shape(0)));
    std::copy_n(array.data(), array.size(), reinterpret_cast<Scalar*>(image.data()));
    return image;
  }
};

template <class P>
struct KeptRow {
  using Scalar = typename PixelTraits<P>::Scalar;
  using State = Packed<Scalar>;
  static State state(const std::vector<P>& row) { return State(array_of(std::vector<P>(row))); }
  static std::vector<P> value(const State& array) {
    constexpr py::ssize_t count = PixelTraits<P>::count;
    gelight::detail::require(
        array.ndim() == (count > 1 ? 2 : 1) && (count == 1 || array.shape(1) == count),
        "the pickle's row has shape ", shape_text(array));
    std::vector<P> row(static_cast<std::size_t>(array.shape(0)));
    std::copy_n(array.data(), array.size(), reinterpret_cast<Scalar*>(row.data()));
    return row;
  }
};
template <class T>
requires std::is_arithmetic_v<T>
struct Kept<std::vector<T>> : KeptRow<T> {
};
template <class T, std::size_t n>
struct Kept<std::vector<std::array<T, n>>> : KeptRow<std::array<T, n>> {};
template <class T, int n>
struct Kept<std::vector<Eigen::Matrix<T, n, 1>>> : KeptRow<Eigen::Matrix<T, n, 1>> {};

template <class E>
requires std::is_enum_v<E>
struct Kept<std::vector<E>> {
  using Number = std::underlying_type_t<E>;
  using State = Packed<Number>;
  static State state(const std::vector<E>& row) {
    std::vector<Number> numbers;
    for (const E one : row) numbers.push_back(static_cast<Number>(one));
    return State(array_of(std::move(numbers)));
  }
  static std::vector<E> value(const State& array) {
    std::vector<E> row;
    for (const Number number : KeptRow<Number>::value(array)) row.push_back(static_cast<E>(number));
    return row;
  }
};

/// A small vector or matrix, column after column.
template <class T, int rows, int columns>
struct Kept<Eigen::Matrix<T, rows, columns>> {
  using State = std::array<T, static_cast<std::size_t>(rows* columns)>;
  static State state(const Eigen::Matrix<T, rows, columns>& matrix) {
    State numbers;
    std::copy_n(matrix.data(), numbers.size(), numbers.begin());
    return numbers;
  }
  static Eigen::Matrix<T, rows, columns> value(const State& numbers) {
    return Eigen::Map<const Eigen::Matrix<T, rows, columns>>(numbers.data());
  }
};

template <class T>
struct Kept<gelight::Mesh<T>> {
  using Positions = Kept<std::vector<std::array<T, 3>>>;
  using Faces = Kept<std::vector<std::array<Index, 3>>>;
  using State = std::tuple<typename Positions::State, typename Faces::State>;
  static State state(const gelight::Mesh<T>& mesh) {
    return {Positions::state(mesh.positions), Faces::state(mesh.faces)};
  }
  static gelight::Mesh<T> value(const State& state) {
    return {Positions::value(std::get<0>(state)), Faces::value(std::get<1>(state))};
  }
};

/// Points as rows of kind, element and weights, bit for bit.
template <class T>
struct Kept<std::vector<gelight::SurfacePoint<T>>> {
  using On = gelight::SurfacePoint<T>;
  using One = std::tuple<int, std::array<Index, 2>, std::array<T, 3>>;
  using State = std::vector<One>;
  static One one(const On& p) { return {static_cast<int>(p.kind), p.element, p.weights}; }
  static On point(const One& one) {
    const auto& [kind, element, weights] = one;
    gelight::detail::require(kind >= 0 && kind <= 2, "the pickle's point is of no kind: ", kind);
    return {static_cast<typename On::Kind>(kind), element, weights};
  }
  static State state(const std::vector<On>& points) {
    State rows;
    for (const On& p : points) rows.push_back(one(p));
    return rows;
  }
  static std::vector<On> value(const State& rows) {
    std::vector<On> points;
    for (const One& row : rows) points.push_back(point(row));
    return points;
  }
};

/// Lets a class be pickled and copied: a type of which these are all members.
template <class T, class... Members>
void keep_by_value(Members T::*... members) {
  using State = std::tuple<typename Kept<Members>::State...>;
  py::class_<T>(py::type::of<T>())
      .def(py::pickle(
          [members...](const T& self) { return State(Kept<Members>::state(self.*members)...); },
          [members...](State state) {
            T made{};
            std::apply(
                [&](auto&... parts) {
                  ((made.*members = Kept<Members>::value(std::move(parts))), ...);
                },
                state);
            return made;
          }));
}
