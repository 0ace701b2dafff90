#pragma once

#include <concepts>
#include <type_traits>

#include "gelight/core/types.hpp"

namespace gelight {

/// How an image type is read. Specialise it for a type of your own with
///
///     static auto width(const I&);                      // integers, in pixels
///     static auto height(const I&);
///     static auto pixel(const I&, Index x, Index y);    // (0, 0) is the top left
///
/// A type that has `width()`, `height()` and `operator()(x, y)` needs no specialisation.
template <class I>
struct ImageTraits;

namespace detail {

template <class I>
concept ImageByMembers = requires(const I& image, Index i) {
  image.width();
  image.height();
  image(i, i);
};

}  // namespace detail

template <detail::ImageByMembers I>
struct ImageTraits<I> {
  static auto width(const I& image) { return image.width(); }
  static auto height(const I& image) { return image.height(); }
  static decltype(auto) pixel(const I& image, Index x, Index y) { return image(x, y); }
};

/// A type for which ImageTraits is specialised.
template <class I>
concept HasImageTraits = requires {
  sizeof(ImageTraits<I>);
};

/// Anything that tells its size and its pixels through ImageTraits. (`Image` is the owning class.)
template <class I>
concept ImageLike = HasImageTraits<I> && requires(const I& image, Index i) {
  { ImageTraits<I>::width(image) } -> std::integral;
  { ImageTraits<I>::height(image) } -> std::integral;
  ImageTraits<I>::pixel(image, i, i);
};

/// The type of an image's pixels.
template <ImageLike I>
using ImagePixel = std::remove_cvref_t<decltype(ImageTraits<I>::pixel(std::declval<const I&>(),
                                                                      Index{}, Index{}))>;

/// An image whose pixels are of type P, or convert to it.
template <class I, class P>
concept ImageOf = ImageLike<I> && std::convertible_to<ImagePixel<I>, P>;

}  // namespace gelight
