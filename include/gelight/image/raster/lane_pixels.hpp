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

/// The same of pixel after pixel.
template <std::size_t size>
struct AreaRows {
  alignas(64) std::array<double, size> a, b, c;

  template <Index lanes>
  void keep(std::size_t at, const Areas<lanes>& areas) {
    store(areas.a, &a[at]), store(areas.b, &b[at]), store(areas.c, &c[at]);
  }

  /// The barycentric coordinates of a pixel in its face. Linear in the image are those divided by
  /// z, and 1 / z.
  template <class T>
  [[nodiscard]] std::array<T, 3> shares(std::size_t at, const Three& inverse_z) const {
    const Four<double> areas{a[at], b[at], c[at], 0};
    const Four<double> parts = areas * Four<double>{inverse_z[0], inverse_z[1], inverse_z[2], 0};
    const auto shares = __builtin_convertvector(parts / (parts[0] + parts[1] + parts[2]), Four<T>);
    return {shares[0], shares[1], shares[2]};
  }
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

  /// Of which pixels it is beyond doubt that they are covered, and their depths.
  struct Covered {
    decltype(Doubles{} < Doubles{}) is;
    Doubles depth;
  };
  /// (Of a pixel beyond the box, an area is negative.)
  [[nodiscard]] Covered at(const Areas<lanes>& areas) {
    const auto& [a, b, c] = areas;
    const Doubles a_or_b = b < a ? b : a, smallest = c < a_or_b ? c : a_or_b;
    const auto is = smallest > doubtful_;
    const Doubles doubt = is ? outside : smallest;
    doubts_ = doubts_ < doubt ? doubt : doubts_;
    const Doubles sum = a * inverse_z_[0] + b * inverse_z_[1] + c * inverse_z_[2];
    const Doubles depth = (a + b + c) / (is ? sum : Doubles{} + 1);
    const Doubles from_least = depth < least_ ? least_ : depth;
    return {is, most_ < from_least ? most_ : from_least};
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
  LaneScreen(const RasterTarget<T>& target, Index face, const Three& inverse_z)
      : target_(target), face_(face), inverse_z_(inverse_z) {}

  /// Pixels side by side, at depths that are infinite where the face covers nothing.
  void add(T* here, const Lanes<double, lanes>& depth, const Areas<lanes>& areas) {
    Lanes<T, lanes> was;
    load(was, here);
    const auto is = __builtin_convertvector(depth, Lanes<T, lanes>);
    const auto is_nearer = is < was;
    store(is_nearer ? is : was, here);
    if (!target_.wants_faces()) return;
    keep(here, areas, bits_of(is_nearer));
    if (!target_.settles_ties()) return;
    const std::uint64_t ties = bits_of((is == was) & (is < std::numeric_limits<T>::infinity()));
    if (ties != 0) add_ties(here, areas, ties);
  }

  /// Shows what was kept.
  void finish() {
    for (; bits_ != 0; bits_ &= bits_ - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(bits_));
      const std::ptrdiff_t place = place_[bit / count] + static_cast<std::ptrdiff_t>(bit % count);
      target_.show(place, face_, areas_.template shares<T>(bit, inverse_z_));
    }
    groups_ = 0;
  }

 private:
  static constexpr std::size_t count = lanes, most = 64;

  void keep(const T* here, const Areas<lanes>& areas, std::uint64_t bits) {
    const std::size_t first = count * groups_;
    bits_ |= bits << first;
    place_[groups_] = target_.place(here);
    areas_.template keep<lanes>(first, areas);
    target_.prefetch_faces(place_[groups_]);
    groups_ += bits != 0 ? 1 : 0;
    if (groups_ == most / count) finish();
  }

  void add_ties(const T* here, const Areas<lanes>& areas, std::uint64_t ties) {
    finish();
    std::uint64_t bits = 0;
    for (; ties != 0; ties &= ties - 1) {
      const Index k = std::countr_zero(ties);
      bits |= target_.is_first(target_.place(here + k), face_) ? std::uint64_t{1} << k : 0;
    }
    keep(here, areas, bits);
  }

  const RasterTarget<T>& target_;
  Index face_;
  Three inverse_z_;
  std::uint64_t bits_ = 0;  // which lanes of all groups are to be shown
  std::size_t groups_ = 0;
  std::array<std::ptrdiff_t, most / count> place_;
  AreaRows<most> areas_;
};

}  // namespace gelight::detail
#endif
