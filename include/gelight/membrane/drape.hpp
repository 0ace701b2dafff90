#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

namespace detail {

/// A neighbour of a pixel, one that is passed before it where the image is gone over forwards, and
/// how far gel falls on the way from there.
template <class T>
struct DrapeStep {
  Index x, y;
  T fall;
};

/// The nearest eight, where gel falls so far to the next pixel.
template <std::floating_point T>
[[nodiscard]] std::array<DrapeStep<T>, 8> drape_steps(T fall) {
  const T diagonal = fall * std::sqrt(T(2)), knight = fall * std::sqrt(T(5));
  return {{{-1, 0, fall},
           {0, -1, fall},
           {-1, -1, diagonal},
           {1, -1, diagonal},
           {-2, -1, knight},
           {2, -1, knight},
           {-1, -2, knight},
           {1, -2, knight}}};
}

/// The depth that a protrusion makes: before the camera, however far it stands out.
template <std::floating_point T>
[[nodiscard]] T risen(T rest, T by) {
  return std::max(rest - by, std::numeric_limits<T>::min());
}

/// Whether a pixel that has risen in a pass backwards would now raise one that was passed before
/// it. What rounding leaves as it is does not count, or passes might not end.
template <std::floating_point T, ImageLike R>
[[nodiscard, gnu::noinline]] bool raises_one_before(const ImageView<T>& depth, const R& rest,
                                                    T fall, Index x, Index y) {
  const auto rest_at = [&](Index u, Index v) {
    return static_cast<T>(ImageTraits<R>::pixel(rest, u, v));
  };
  const T own = protrusion(depth(x, y), rest_at(x, y));
  for (const DrapeStep<T>& step : drape_steps(fall)) {
    const Index u = x - step.x, v = y - step.y;
    if (u < 0 || u >= depth.width() || v < 0 || v >= depth.height()) continue;
    const T here = own - step.fall;
    const bool raises = here > protrusion(depth(u, v), rest_at(u, v));
    if (raises && risen(rest_at(u, v), here) < depth(u, v)) return true;
  }
  return false;
}

/// Raises each pixel's protrusion to that of its neighbours which were passed before, less what
/// gel falls on the way: forwards over the image, or backwards. Returns whether that takes another
/// pass forwards, as where the shortest way turns back around pixels that are not known.
template <std::floating_point T, ImageLike R>
bool drape_pass(ImageView<T> depth, const R& rest, T fall, bool forwards) {
  const auto steps = drape_steps(fall);
  const Index width = depth.width(), height = depth.height(), sign = forwards ? 1 : -1;
  const auto rest_at = [&](Index x, Index y) {
    return static_cast<T>(ImageTraits<R>::pixel(rest, x, y));
  };
  bool is_unsettled = false;
  for (Index j = 0; j < height; ++j) {
    for (Index i = 0; i < width; ++i) {
      const Index x = forwards ? i : width - 1 - i, y = forwards ? j : height - 1 - j;
      const T own = protrusion(depth(x, y), rest_at(x, y));
      T most = own;
      for (const DrapeStep<T>& step : steps) {
        const Index u = x + sign * step.x, v = y + sign * step.y;
        if (u < 0 || u >= width || v < 0 || v >= height) continue;
        const T there = protrusion(depth(u, v), rest_at(u, v)) - step.fall;
        if (there > most) most = there;  // false where either is not known
      }
      if (!(most > own)) continue;
      depth(x, y) = risen(rest_at(x, y), most);
      if (!forwards && !is_unsettled) is_unsettled = raises_one_before(depth, rest, fall, x, y);
    }
  }
  return is_unsettled;
}

/// Whether a pixel of an image lies in memory between a view's first pixel and its last. False
/// where the image gives its pixels by value.
template <class T, ImageLike R>
[[nodiscard]] bool may_share_memory(ImageView<T> view, const R& image) {
  if constexpr (std::is_lvalue_reference_v<decltype(ImageTraits<R>::pixel(image, 0, 0))>) {
    if (view.width() == 0 || view.height() == 0) return false;
    using Place = std::uintptr_t;
    Place first = std::numeric_limits<Place>::max(), last = 0;
    for (const Index y : {Index{0}, view.height() - 1}) {
      for (const Index x : {Index{0}, view.width() - 1}) {
        const auto place = reinterpret_cast<Place>(&view(x, y));
        first = std::min(first, place);
        last = std::max(last, place);
      }
    }
    for (Index y = 0; y < view.height(); ++y) {
      for (Index x = 0; x < view.width(); ++x) {
        const auto place = reinterpret_cast<Place>(&ImageTraits<R>::pixel(image, x, y));
        if (place >= first && place <= last) return true;
      }
    }
  }
  return false;
}

/// Whether every pixel of an image is the view's own at that place.
template <class T, ImageLike D>
[[nodiscard]] bool is_same_memory(ImageView<T> view, const D& image) {
  if constexpr (std::is_lvalue_reference_v<decltype(ImageTraits<D>::pixel(image, 0, 0))>) {
    for (Index y = 0; y < view.height(); ++y) {
      for (Index x = 0; x < view.width(); ++x) {
        if (&view(x, y) != &ImageTraits<D>::pixel(image, x, y)) return false;
      }
    }
    return true;
  }
  return false;
}

/// An image's numbers in memory of their own.
template <std::floating_point T, ImageLike D>
[[nodiscard]] Image<T> copy_of(const D& image) {
  Image<T> copy(static_cast<Index>(ImageTraits<D>::width(image)),
                static_cast<Index>(ImageTraits<D>::height(image)));
  for (Index y = 0; y < copy.height(); ++y) {
    for (Index x = 0; x < copy.width(); ++x) {
      copy(x, y) = static_cast<T>(ImageTraits<D>::pixel(image, x, y));
    }
  }
  return copy;
}

/// The same as drape_into, where `out` shares no memory with the rest depth, nor with the depth
/// map but pixel by pixel.
template <std::floating_point T, ImageLike D, ImageLike R>
void drape_beside(ImageView<T> out, const D& depth, const R& rest, T fall) {
  for (Index y = 0; y < out.height(); ++y) {
    for (Index x = 0; x < out.width(); ++x) {
      out(x, y) = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
    }
  }
  do {
    drape_pass<T>(out, rest, fall, true);
  } while (drape_pass<T>(out, rest, fall, false));
}

}  // namespace detail

/// Lays gel over the outlines of what is pressed in, for objects that are in it past their widest
/// place: `out` becomes the depth map with protrusions that fall by no more than `fall` from pixel
/// to pixel, in the unit of the depth, like a tent that hangs from the outline.
///
/// A ball deeper in the gel than its middle hides what is behind it: its depth jumps at the
/// outline, and a GaussianMembrane or a BulgingMembrane with it, so that the image has a rim of
/// dots. A fall of 4 times the width of a pixel on the membrane, 76 degrees, takes the dots away
/// and leaves alone what is not steeper. Along upright walls across the pixels dots are left: the
/// stairs of the outline, of which a smaller fall makes streaks. Ways are measured in steps to a
/// pixel's sixteen nearest neighbours (Borgefors, Distance transformations in digital images, 1986,
/// doi:10.1016/S0734-189X(86)80047-0). Pixels that are not known stay so. `out` may be the depth
/// map itself; where it may share memory with the rest depth, or with the depth map's pixels
/// elsewhere, that is copied first (not seen of image types that give their pixels by value: these
/// must not share it). Takes two passes over the image, and more where the shortest way leads back
/// and forth around pixels that are not known. Throws InvalidInput, before anything is written, for
/// images of different sizes and a fall that is not positive and finite.
template <ImageLike D, ImageLike R>
requires std::floating_point<ImagePixel<D>>
void drape_into(std::type_identity_t<ImageView<ImagePixel<D>>> out, const D& depth, const R& rest,
                std::type_identity_t<ImagePixel<D>> fall) {
  using T = ImagePixel<D>;
  detail::require_same_size(depth, rest, "the depth image", "the rest depth image");
  detail::require_same_size(out, rest, "the output image", "the rest depth image");
  detail::require(fall > 0 && std::isfinite(fall), "a fall of ", fall,
                  " is not positive and finite");
  if (detail::may_share_memory<T>(out, depth) && !detail::is_same_memory<T>(out, depth))
    return drape_into(out, detail::copy_of<T>(depth), rest, fall);
  if (detail::may_share_memory<T>(out, rest))
    return detail::drape_beside<T>(out, depth, detail::copy_of<T>(rest), fall);
  detail::drape_beside<T>(out, depth, rest, fall);
}

/// The same as an image of its own.
template <ImageLike D, ImageLike R>
requires std::floating_point<ImagePixel<D>>
[[nodiscard]] Image<ImagePixel<D>> drape(const D& depth, const R& rest,
                                         std::type_identity_t<ImagePixel<D>> fall) {
  Image<ImagePixel<D>> out(static_cast<Index>(ImageTraits<D>::width(depth)),
                           static_cast<Index>(ImageTraits<D>::height(depth)));
  drape_into(out, depth, rest, fall);
  return out;
}

}  // namespace gelight
