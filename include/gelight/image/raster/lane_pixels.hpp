#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/image/raster/faces.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/targets.hpp"

#if defined(__GNUC__)
namespace gelight::detail {

/// Pixels of a face, a lane each: the first four lie side by side in the target, and so do the four
/// others if there are any.
template <class T, Index lanes>
struct LanePixels {
  using Doubles = Lanes<double, lanes>;
  std::size_t face;  // in the batch
  T *here, *there;   // depths
  Doubles depth;     // infinite where the face covers nothing
  Doubles a, b, c;   // the areas that the pixels span with the sides
};

/// Shows pixels in a target: depths at once. Faces and places in them are kept until there are many
/// pixels, for how many of the lanes are to be shown is hard to foretell.
template <class T, Index lanes>
class LaneScreen {
 public:
  using Pixels = LanePixels<T, lanes>;

  LaneScreen(const RasterTarget<T>& target, const FaceBatch& batch, const FaceMeasures& measures)
      : target_(target), batch_(batch), of_(measures) {}

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

  /// Shows what was kept. Linear in the image are the barycentric coordinates divided by z, and 1 /
  /// z.
  void finish() {
    for (; bits_ != 0; bits_ &= bits_ - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(bits_));
      const std::size_t i = face_[bit / count];
      const Four<double> areas{a_[bit], b_[bit], c_[bit], 0};
      const Four<double> parts =
          areas * Four<double>{of_.inverse_z[0][i], of_.inverse_z[1][i], of_.inverse_z[2][i], 0};
      const double sum = parts[0] + parts[1] + parts[2];
      const auto shares = __builtin_convertvector(parts / sum, Four<T>);
      target_.show(place(bit), batch_.faces[i], {shares[0], shares[1], shares[2]});
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
    store(a_, first, pixels.a);
    store(b_, first, pixels.b);
    store(c_, first, pixels.c);
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
      bits |= target_.is_first(target_.place(at), batch_.faces[pixels.face]) ? std::uint64_t{1} << k
                                                                             : 0;
    }
    keep(pixels, bits);
  }

  const RasterTarget<T>& target_;
  const FaceBatch& batch_;
  const FaceMeasures& of_;
  std::uint64_t bits_ = 0;  // which lanes of all groups are to be shown
  std::size_t groups_ = 0;
  std::array<std::size_t, most / count> face_;
  std::array<std::ptrdiff_t, most / 4> place_;
  alignas(Lanes<double, lanes>) std::array<double, most> a_, b_, c_;
};

}  // namespace gelight::detail
#endif
