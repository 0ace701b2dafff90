#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/targets.hpp"

#if defined(__GNUC__)
namespace gelight::detail {

/// Pixels of a face, a lane each: the first four lie side by side in the target, and so do the four
/// others if there are any. Linear in the image are 1 / z, and the barycentric coordinates divided
/// by z: these are the parts.
template <class T, Index lanes>
struct LanePixels {
  using Doubles = Lanes<double, lanes>;
  Index face;
  T *here, *there;  // depths
  Doubles depth;    // infinite where the face covers nothing
  Doubles part_a, part_b, part_c, sum;
};

/// Shows pixels in a target: depths at once. Faces and places in them are kept until there are many
/// pixels, for how many of the lanes are to be shown is hard to foretell.
template <class T, Index lanes>
class LaneScreen {
 public:
  using Pixels = LanePixels<T, lanes>;

  explicit LaneScreen(const RasterTarget<T>& target) : target_(target) {}

  void add(const Pixels& pixels) {
    Lanes<T, lanes> was;
    load_pixels(was, pixels.here, pixels.there);
    const auto is = __builtin_convertvector(pixels.depth, Lanes<T, lanes>);
    const auto is_nearer = is < was;
    const Lanes<T, lanes> now = is_nearer ? is : was;
    store_pixels(now, pixels.here, pixels.there);
    if (!target_.wants_faces()) return;
    keep(pixels, bits_of(is_nearer));
    if (!target_.settles_ties()) return;
    const std::uint64_t ties = bits_of((is == was) & (is < std::numeric_limits<T>::infinity()));
    if (ties != 0) add_ties(pixels, ties);
  }

  /// Shows what was kept.
  void finish() {
    for (; bits_ != 0; bits_ &= bits_ - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(bits_));
      const Four<double> parts{part_a_[bit], part_b_[bit], part_c_[bit], 1};
      const auto shares = __builtin_convertvector(parts / sum_[bit], Four<T>);
      target_.show(place(bit), face_[bit / count], {shares[0], shares[1], shares[2]});
    }
    groups_ = 0;
  }

 private:
  static constexpr std::size_t count = lanes, most = 64;

  [[nodiscard]] std::ptrdiff_t place(std::size_t bit) const {
    return place_[bit / 4] + static_cast<std::ptrdiff_t>(bit % 4);
  }

  void keep(const Pixels& pixels, std::uint64_t bits) {
    const std::size_t first = count * groups_;
    bits_ |= bits << first;
    face_[groups_] = pixels.face;
    const std::ptrdiff_t here = target_.place(pixels.here), there = target_.place(pixels.there);
    place_[first / 4] = here, place_[(first + count - 1) / 4] = there;
    store(part_a_, first, pixels.part_a);
    store(part_b_, first, pixels.part_b);
    store(part_c_, first, pixels.part_c);
    store(sum_, first, pixels.sum);
    target_.prefetch_faces(here);
    if constexpr (lanes > 4) target_.prefetch_faces(there);
    groups_ += bits != 0 ? 1 : 0;
    if (groups_ == most / count) finish();
  }

  static void store(std::array<double, most>& into, std::size_t at,
                    const Lanes<double, lanes>& numbers) {
    std::memcpy(&into[at], &numbers, sizeof numbers);
  }

  void add_ties(const Pixels& pixels, std::uint64_t ties) {
    finish();
    std::uint64_t bits = 0;
    for (; ties != 0; ties &= ties - 1) {
      const Index k = std::countr_zero(ties);
      const T* const at = k < 4 ? pixels.here + k : pixels.there + (k - 4);
      bits |= target_.is_first(target_.place(at), pixels.face) ? std::uint64_t{1} << k : 0;
    }
    keep(pixels, bits);
  }

  const RasterTarget<T>& target_;
  std::uint64_t bits_ = 0;  // which lanes of all groups are to be shown
  std::size_t groups_ = 0;
  std::array<Index, most / count> face_;
  std::array<std::ptrdiff_t, most / 4> place_;
  alignas(Lanes<double, lanes>) std::array<double, most> part_a_, part_b_, part_c_, sum_;
};

}  // namespace gelight::detail
#endif
