#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "gelight/concepts/image.hpp"
#include "gelight/core/bits.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// What a channel can be: a share of full light, or a level of an image of 8 or 16 bits. Of larger
/// integers, and of those with a sign, nobody knows what is full light.
template <class C>
concept ColourChannel = std::floating_point<C> ||(std::unsigned_integral<C> && sizeof(C) <= 2);

/// A channel as a number: integers are shares of their type's largest value, the rest is as it is.
template <std::floating_point T, ColourChannel C>
[[nodiscard]] T channel(C value) {
  if constexpr (std::integral<C>) {
    return static_cast<T>(value) / static_cast<T>(std::numeric_limits<C>::max());
  } else {
    return static_cast<T>(value);
  }
}

/// How many channels a pixel has; 3 where its type does not say.
template <class P>
[[nodiscard]] constexpr int channel_count() {
  if constexpr (requires { std::tuple_size<P>::value; }) {
    return static_cast<int>(std::tuple_size<P>::value);
  } else if constexpr (requires { P::SizeAtCompileTime; }) {
    return P::SizeAtCompileTime;
  } else {
    return 3;
  }
}

/// Three channels that can be read as pixel[0], pixel[1], pixel[2].
template <class P>
concept Rgb = requires(const P& pixel) {
  requires ColourChannel<std::remove_cvref_t<decltype(pixel[0])>>;
}
&&channel_count<P>() == 3;

/// Three channels, or one, which is grey.
template <class P>
concept Colour = Rgb<P> || ColourChannel<P>;

/// The first channel, or the only one.
template <Colour P>
[[nodiscard]] auto first_channel(const P& pixel) {
  if constexpr (Rgb<P>) {
    return pixel[0];
  } else {
    return pixel;
  }
}

/// Whether a colour's channels are integers, which are shares of full light whatever they are.
template <Colour P>
[[nodiscard]] constexpr bool has_levels() {
  return std::integral<decltype(first_channel(std::declval<const P&>()))>;
}

/// An image of colours.
template <class I>
concept ColourImage = ImageLike<I> && Colour<ImagePixel<I>>;

template <std::floating_point T, Colour P>
[[nodiscard]] std::array<T, 3> linear_rgb(const P& pixel) {
  if constexpr (Rgb<P>) {
    return {channel<T>(pixel[0]), channel<T>(pixel[1]), channel<T>(pixel[2])};
  } else {
    const T grey = channel<T>(pixel);
    return {grey, grey, grey};
  }
}

/// Whether a number is a share of full light.
template <std::floating_point T>
[[nodiscard]] bool is_share_of_light(T value) {
  return value >= 0 && value <= T(1 + beyond_full_light);
}

/// Whether the numbers of a row are shares of full light, but that it may say no of -0: numbers
/// without a sign are in the order of their bits, and those with one, or that are none, are above.
template <std::floating_point T>
[[nodiscard]] bool are_shares_of_light(const T* row, Index count) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  Bits largest = 0;
  for (Index i = 0; i < count; ++i) largest = std::max(largest, detail::bit_cast<Bits>(row[i]));
  return largest <= detail::bit_cast<Bits>(T(1 + beyond_full_light));
}

/// The same of all channels of an image.
template <ColourImage I>
[[nodiscard]] bool are_shares_of_light(const I& image) {
  using P = ImagePixel<I>;
  using C = decltype(first_channel(std::declval<const P&>()));
  const auto width = static_cast<Index>(ImageTraits<I>::width(image));
  const auto height = static_cast<Index>(ImageTraits<I>::height(image));
  if constexpr (std::convertible_to<const I&, ImageView<const P>> && sizeof(P) % sizeof(C) == 0) {
    const ImageView<const P> view = image;
    constexpr auto channels = static_cast<Index>(sizeof(P) / sizeof(C));
    for (Index y = 0; y < height && view.rows_are_packed(); ++y) {
      const C* const row = reinterpret_cast<const C*>(view.row(y));
      if (!are_shares_of_light(row, channels * width)) return false;
    }
    if (view.rows_are_packed()) return true;
  }
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const auto rgb = linear_rgb<C>(ImageTraits<I>::pixel(image, x, y));
      if (!are_shares_of_light(rgb.data(), 3)) return false;
    }
  }
  return true;
}

/// Throws InvalidInput unless a colour is in shares of full light; its name is joined of parts.
template <std::floating_point T, class... Name>
void require_colour(const std::array<T, 3>& rgb, const Name&... name) {
  require(is_share_of_light(rgb[0]) && is_share_of_light(rgb[1]) && is_share_of_light(rgb[2]),
          name..., " is (", rgb[0], ", ", rgb[1], ", ", rgb[2],
          "), which is not in shares of full light from 0 to 1");
}

}  // namespace detail

/// What the camera would see of the membrane by ambient light alone, as linear RGB in [0, 1]:
/// nothing, one colour, or an image.
template <std::floating_point T>
class Background {
 public:
  /// Black.
  Background() = default;

  /// One colour, red, green, blue: floating-point numbers, or integers of 8 or 16 bits without sign
  /// as shares of their type's largest value. Throws InvalidInput where a share is not from 0 to 1.
  template <detail::ColourChannel C>
  Background(const std::array<C, 3>& rgb) : solid_(detail::linear_rgb<T>(rgb)) {
    detail::require_colour(solid_, "the background colour");
  }

  /// An image, grey or RGB, of the same numbers. Throws InvalidInput where a share is not from 0 to
  /// 1.
  template <detail::ColourImage I>
  Background(const I& image)
      : image_(static_cast<Index>(ImageTraits<I>::width(image)),
               static_cast<Index>(ImageTraits<I>::height(image))),
        is_image_(true) {
    for (Index y = 0; y < image_.height(); ++y) {
      for (Index x = 0; x < image_.width(); ++x) {
        image_(x, y) = detail::linear_rgb<T>(ImageTraits<I>::pixel(image, x, y));
        detail::require_colour(image_(x, y), "background pixel (", x, ", ", y, ")");
      }
    }
  }

  /// Whether it is an image; else it is one colour.
  [[nodiscard]] bool is_image() const { return is_image_; }
  /// The image, in shares of full light; empty where the background is one colour.
  [[nodiscard]] const Image<std::array<T, 3>>& image() const { return image_; }
  /// The colour, in shares of full light, where the background is no image.
  [[nodiscard]] const std::array<T, 3>& solid() const { return solid_; }

 private:
  std::array<T, 3> solid_{};
  Image<std::array<T, 3>> image_;
  bool is_image_ = false;
};

}  // namespace gelight
