#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/targets.hpp"

#if defined(__GNUC__)
namespace gelight::detail {

/// The areas that pixels span with the sides of faces.
template <Index lanes>
struct Areas {
  Lanes<double, lanes> a, b, c;
};

/// Barycentric coordinates of pixels in their faces, pixel after pixel.
template <class T, std::size_t size>
struct ShareRows {
  alignas(64) std::array<T, size> a, b, c;

  template <Index lanes>
  void keep(std::size_t at, const Areas<lanes>& shares) {
    store(__builtin_convertvector(shares.a, Lanes<T, lanes>), &a[at]);
    store(__builtin_convertvector(shares.b, Lanes<T, lanes>), &b[at]);
    store(__builtin_convertvector(shares.c, Lanes<T, lanes>), &c[at]);
  }
  [[nodiscard]] std::array<T, 3> of(std::size_t at) const { return {a[at], b[at], c[at]}; }
};

/// Tells which pixels faces cover, and at which depths: all of one face, or a face a lane.
template <Index lanes>
class Cover {
 public:
  using Doubles = Lanes<double, lanes>;

  /// `doubtful`: areas up to this may have the wrong sign. `least`, `most`: the depths of corners.
  Cover(const Doubles& doubtful, const Doubles& least, const Doubles& most,
        const std::array<Doubles, 3>& inverse_z)
      : doubtful_(doubtful), least_(least), most_(most), inverse_z_(inverse_z) {}

  /// Of which pixels it is beyond doubt that they are covered, and their depths and barycentric
  /// coordinates.
  struct Covered {
    decltype(Doubles{} < Doubles{}) is;
    Doubles depth;
    Areas<lanes> shares;
  };
  /// (Of a pixel beyond the box, an area is negative.)
  [[nodiscard]] Covered at(const Areas<lanes>& areas) {
    const auto& [a, b, c] = areas;
    const Doubles a_or_b = b < a ? b : a, smallest = c < a_or_b ? c : a_or_b;
    const auto is = smallest > doubtful_;
    const Doubles doubt = is ? outside : smallest;
    doubts_ = doubts_ < doubt ? doubt : doubts_;
    // Linear in the image are 1 / z, and the barycentric coordinates divided by z.
    const Doubles one = Doubles{} + 1;
    const Areas<lanes> parts{a * inverse_z_[0], b * inverse_z_[1], c * inverse_z_[2]};
    const Doubles sum = parts.a + parts.b + parts.c, inverse = one / (is ? sum : one);
    const Doubles depth = (a + b + c) * inverse;
    const Doubles from_least = depth < least_ ? least_ : depth;
    return {is,
            most_ < from_least ? most_ : from_least,
            {parts.a * inverse, parts.b * inverse, parts.c * inverse}};
  }
  /// In which lanes there were pixels about which rounding leaves a doubt.
  [[nodiscard]] std::uint64_t doubts() const { return bits_of(doubts_ >= -doubtful_); }

 private:
  static constexpr Doubles outside = Doubles{} - std::numeric_limits<double>::infinity();

  Doubles doubtful_, least_, most_;
  std::array<Doubles, 3> inverse_z_;
  Doubles doubts_ = outside;  // the largest of the smallest areas of pixels that are not covered
};

/// Shows pixels of a face in a target: depths at once. Where they are in the face is kept until
/// there are many, for how many of the lanes are to be shown is hard to foretell.
template <class T, Index lanes>
class LaneScreen {
 public:
  LaneScreen(const RasterTarget<T>& target, Index face) : target_(target), face_(face) {}

  /// Pixels side by side, at depths that are infinite where the face covers nothing.
  void add(T* here, const Lanes<double, lanes>& depth, const Areas<lanes>& shares) {
    Lanes<T, lanes> was;
    load(was, here);
    const auto is = __builtin_convertvector(depth, Lanes<T, lanes>);
    const auto is_nearer = is < was;
    store(is_nearer ? is : was, here);
    if (!target_.wants_faces()) return;
    keep(here, shares, bits_of(is_nearer));
    if (!target_.settles_ties()) return;
    const std::uint64_t ties = bits_of((is == was) & (is < std::numeric_limits<T>::infinity()));
    if (ties != 0) add_ties(here, shares, ties);
  }

  /// Shows what was kept.
  void finish() {
    for (; bits_ != 0; bits_ &= bits_ - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(bits_));
      const std::ptrdiff_t place = place_[bit / count] + static_cast<std::ptrdiff_t>(bit % count);
      target_.show(place, face_, shares_.of(bit));
    }
    groups_ = 0;
  }

 private:
  static constexpr std::size_t count = lanes, most = 64;

  void keep(const T* here, const Areas<lanes>& shares, std::uint64_t bits) {
    const std::size_t first = count * groups_;
    bits_ |= bits << first;
    place_[groups_] = target_.place(here);
    shares_.template keep<lanes>(first, shares);
    target_.prefetch_faces(place_[groups_]);
    groups_ += bits != 0 ? 1 : 0;
    if (groups_ == most / count) finish();
  }

  void add_ties(const T* here, const Areas<lanes>& shares, std::uint64_t ties) {
    finish();
    std::uint64_t bits = 0;
    for (; ties != 0; ties &= ties - 1) {
      const Index k = std::countr_zero(ties);
      bits |= target_.is_first(target_.place(here + k), face_) ? std::uint64_t{1} << k : 0;
    }
    keep(here, shares, bits);
  }

  const RasterTarget<T>& target_;
  Index face_;
  std::uint64_t bits_ = 0;  // which lanes of all groups are to be shown
  std::size_t groups_ = 0;
  std::array<std::ptrdiff_t, most / count> place_;
  ShareRows<T, most> shares_;
};

}  // namespace gelight::detail
#endif
