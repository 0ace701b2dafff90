#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/core/pages.hpp"

namespace gelight::detail {

/// What can be read from one place to the next: what std::input_iterator asks for takes a compiler
/// more time, for every kind of element, than the loop does.
template <class It>
concept ReadForward = requires(It i) {
  *i;
  ++i;
};

/// What std::vector is, but with a subscript of any sign, so that an Index needs no cast, and with
/// few functions, so that the dozens of kinds in the library compile quickly. Its memory begins at
/// a multiple of `alignment` bytes.
template <class T, std::size_t alignment = alignof(T)>
class Array {
 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  Array() = default;
  explicit Array(std::size_t count) : Array() { resize(count); }
  Array(std::size_t count, const T& value) : Array() { resize(count, value); }
  template <ReadForward It>
  Array(It first, It last) : Array() {
    append(first, last);
  }
  Array(std::initializer_list<T> values) : Array() { append(values.begin(), values.end()); }
  Array(const Array& other) : Array() { append(other.begin(), other.end()); }
  Array(Array&& other) noexcept : Array() { swap(other); }
  Array& operator=(const Array& other) {
    if (this != &other) assign(other.begin(), other.end());
    return *this;
  }
  Array& operator=(Array&& other) noexcept {
    Array taken(std::move(other));
    swap(taken);
    return *this;
  }
  ~Array() {
    clear();
    give_back();
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] T* begin() { return data_; }
  [[nodiscard]] const T* begin() const { return data_; }
  [[nodiscard]] T* end() { return data_ + size_; }
  [[nodiscard]] const T* end() const { return data_ + size_; }
  [[nodiscard, gnu::always_inline]] T& operator[](std::integral auto i) { return data_[i]; }
  [[nodiscard, gnu::always_inline]] const T& operator[](std::integral auto i) const {
    return data_[i];
  }
  [[nodiscard]] T& front() { return *data_; }
  [[nodiscard]] const T& front() const { return *data_; }
  [[nodiscard]] T& back() { return data_[size_ - 1]; }
  [[nodiscard]] const T& back() const { return data_[size_ - 1]; }
  /// A copy, for who keeps vectors.
  operator std::vector<T>() const { return std::vector<T>(begin(), end()); }
  [[nodiscard]] bool operator==(const Array& other) const {
    return std::equal(begin(), end(), other.begin(), other.end());
  }

  void swap(Array& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }
  void reserve(std::size_t count) {
    if (count > capacity_) move_to(count);
  }
  /// Room for values all of which are about to be added.
  void reserve_for_all(std::size_t count) {
    if (count <= capacity_) return;
    move_to(count);
    expect_writes(data_ + size_, (count - size_) * sizeof(T));
  }
  [[gnu::noinline]] void resize(std::size_t count) {
    make_room_for_all(count);
    if constexpr (std::is_trivial_v<T>) {
      if (size_ < count) std::memset(data_ + size_, 0, (count - size_) * sizeof(T));
      size_ = count;
    } else {
      for (; size_ < count; ++size_) new (data_ + size_) T();
      cut(count);
    }
  }
  /// The same, but for values that are trivial: those that are new are whatever was there, and
  /// their memory is not touched.
  void resize_unwritten(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>);
    make_room(count);
    // (A loop that does nothing is left out by the compiler from -O2 on only.)
    if constexpr (!std::is_trivially_default_constructible_v<T>) {
      for (T* made = data_ + size_; made < data_ + count; ++made) new (made) T;
    }
    size_ = count;
  }
  /// The same for values all of which are about to be written.
  void resize_for_writes(std::size_t count) {
    reserve_for_all(count);
    resize_unwritten(count);
  }
  [[gnu::noinline]] void resize(std::size_t count, const T& value) {
    // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): it may be one of these
    const T kept = value;
    make_room_for_all(count);
    if constexpr (std::is_trivial_v<T>) {
      if (size_ < count) std::fill(data_ + size_, data_ + count, kept);
      size_ = count;
    } else {
      for (; size_ < count; ++size_) new (data_ + size_) T(kept);
      cut(count);
    }
  }
  void assign(std::size_t count, const T& value) {
    // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): likewise
    const T kept = value;
    clear();
    resize(count, kept);
  }
  template <ReadForward It>
  void assign(It first, It last) {
    clear();
    append(first, last);
  }
  template <ReadForward It>
  [[gnu::noinline]] void append(It first, It last) {
    if constexpr (requires { last - first; }) {
      make_room(size_ + static_cast<std::size_t>(last - first));
    }
    for (; first != last; ++first) emplace_back(*first);
  }
  void push_back(const T& value) { emplace_back(value); }
  void push_back(T&& value) { emplace_back(std::move(value)); }
  template <class... Parts>
  T& emplace_back(Parts&&... parts) {
    if (size_ == capacity_) return emplace_elsewhere(std::forward<Parts>(parts)...);
    T* const made = new (data_ + size_) T(std::forward<Parts>(parts)...);
    ++size_;
    return *made;
  }
  void pop_back() { cut(size_ - 1); }
  void clear() { cut(0); }
  /// Drops what comes from `end` on, which may be what a standard algorithm left behind.
  void keep_until(const T* end) { cut(static_cast<std::size_t>(end - data_)); }

 private:
  static_assert(alignment >= alignof(T), "elements would lie beside what they need");
  static constexpr bool is_aligned = alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__;

  // The new one is made first, for it may be made of one of these.
  template <class... Parts>
  [[gnu::noinline]] T& emplace_elsewhere(Parts&&... parts) {
    T value(std::forward<Parts>(parts)...);
    make_room(size_ + 1);
    T* const made = new (data_ + size_) T(std::move(value));
    ++size_;
    return *made;
  }
  void make_room(std::size_t count) {
    if (count > capacity_) move_to(std::max(count, 2 * capacity_));
  }
  void make_room_for_all(std::size_t count) {
    if (count <= capacity_) return;
    make_room(count);
    expect_writes(data_ + size_, (count - size_) * sizeof(T));
  }
  [[gnu::noinline]] void move_to(std::size_t capacity) {
    static_assert(std::is_nothrow_move_constructible_v<T>, "elements would be lost half-way");
    if (capacity > std::size_t{std::numeric_limits<std::ptrdiff_t>::max()} / sizeof(T)) {
      throw std::bad_array_new_length();
    }
    T* const there = take(capacity);
    for (std::size_t i = 0; i < size_; ++i) {
      new (there + i) T(std::move(data_[i]));
      data_[i].~T();
    }
    give_back();
    data_ = there;
    capacity_ = capacity;
  }
  void cut(std::size_t count) {
    if constexpr (std::is_trivially_destructible_v<T>) {
      size_ = std::min(size_, count);
    } else {
      while (size_ > count) data_[--size_].~T();
    }
  }
  static T* take(std::size_t capacity) {
    if constexpr (is_aligned) {
      return static_cast<T*>(::operator new (capacity * sizeof(T), std::align_val_t{alignment}));
    } else {
      return static_cast<T*>(::operator new(capacity * sizeof(T)));
    }
  }
  void give_back() {
    if constexpr (is_aligned) {
      ::operator delete (data_, std::align_val_t{alignment});
    } else {
      ::operator delete(data_);
    }
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// std::span with a signed subscript, and without its checks of iterators, which every kind of
/// element would compile anew.
template <class T>
class Slice {
 public:
  Slice() = default;
  Slice(T* first, std::size_t count) : data_(first), size_(count) {}
  /// All of an array, a vector, a span, or another slice.
  ///@{
  template <class Values>
  requires requires(Values& values) { static_cast<T*>(values.data()); }
  Slice(Values& values) : data_(values.data()), size_(values.size()) {}
  template <class Values>
  requires requires(const Values& values) { static_cast<T*>(values.data()); }
  Slice(const Values& values) : data_(values.data()), size_(values.size()) {}
  ///@}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() const { return data_; }
  [[nodiscard]] T* begin() const { return data_; }
  [[nodiscard]] T* end() const { return data_ + size_; }
  [[nodiscard]] T& operator[](std::ptrdiff_t i) const { return data_[i]; }
  [[nodiscard]] T& front() const { return *data_; }
  [[nodiscard]] T& back() const { return data_[size_ - 1]; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace gelight::detail

// As of a std::span: what an algorithm of std::ranges finds in a slice that a function returned is
// no part of that slice, but of what it shows. (Declared where std::string_view is; not a matter of
// the reference.)
/// @cond
template <class T>
inline constexpr bool std::ranges::enable_borrowed_range<gelight::detail::Slice<T>> = true;
template <class T>
inline constexpr bool std::ranges::enable_view<gelight::detail::Slice<T>> = true;
/// @endcond
