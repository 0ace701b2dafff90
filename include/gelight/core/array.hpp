#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gelight::detail {

/// std::vector with a signed subscript, so that an Index needs no cast.
template <class T>
class Array : public std::vector<T> {
 public:
  using std::vector<T>::vector;
  [[nodiscard]] T& operator[](std::ptrdiff_t i) { return this->data()[i]; }
  [[nodiscard]] const T& operator[](std::ptrdiff_t i) const { return this->data()[i]; }
};

/// std::span with a signed subscript.
template <class T>
class Slice : public std::span<T> {
 public:
  using std::span<T>::span;
  Slice(std::span<T> whole) : std::span<T>(whole) {}
  [[nodiscard]] T& operator[](std::ptrdiff_t i) const { return this->data()[i]; }
};

}  // namespace gelight::detail
