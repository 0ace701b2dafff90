#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// A channel as a number: integers are shares of their type's largest value, the rest is as it is.
template <std::floating_point T, class C>
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
  requires std::is_arithmetic_v<std::remove_cvref_t<decltype(pixel[0])>>;
}
&&channel_count<P>() == 3;

template <std::floating_point T, class P>
[[nodiscard]] std::array<T, 3> linear_rgb(const P& pixel) {
  if constexpr (Rgb<P>) {
    return {channel<T>(pixel[0]), channel<T>(pixel[1]), channel<T>(pixel[2])};
  } else {
    const T grey = channel<T>(pixel);
    return {grey, grey, grey};
  }
}

}  // namespace detail

/// What the camera would see of the membrane by ambient light alone, as linear RGB in [0, 1]:
/// nothing, one colour, or an image.
template <std::floating_point T>
class Background {
 public:
  /// Black.
  Background() = default;

  /// One colour, red, green, blue. Throws InvalidInput where a number is not finite.
  template <class C>
  requires(std::is_arithmetic_v<C>) Background(const std::array<C, 3>& rgb)
      : solid_(detail::linear_rgb<T>(rgb)) {
    require_finite(solid_, "the background colour");
  }

  /// An image, grey or RGB; integers are shares of their type's largest value.
  /// Throws InvalidInput where a number is not finite.
  template <ImageLike I>
  Background(const I& image)
      : image_(static_cast<Index>(ImageTraits<I>::width(image)),
               static_cast<Index>(ImageTraits<I>::height(image))),
        is_image_(true) {
    for (Index y = 0; y < image_.height(); ++y) {
      for (Index x = 0; x < image_.width(); ++x) {
        image_(x, y) = detail::linear_rgb<T>(ImageTraits<I>::pixel(image, x, y));
        require_finite(image_(x, y), "background pixel (", x, ", ", y, ")");
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
  template <class... Where>
  static void require_finite(const std::array<T, 3>& rgb, const Where&... where) {
    detail::require(std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2]),
                    where..., " is (", rgb[0], ", ", rgb[1], ", ", rgb[2], "), not finite");
  }

  std::array<T, 3> solid_{};
  Image<std::array<T, 3>> image_;
  bool is_image_ = false;
};

}  // namespace gelight
