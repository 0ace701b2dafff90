#pragma once

#include <concepts>
#include <cstddef>
#include <limits>

#include "gelight/concepts/image.hpp"
#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/views/image_view.hpp"

// What membrane models make of depths; image/mask.hpp tells what those mean.
namespace gelight::detail {

/// The contact's depth where there is one that is no deeper than the membrane at rest (or than
/// `allowed`), the rest depth elsewhere.
template <class T>
[[nodiscard]] T contact_depth(T depth, T rest, T allowed) {
  const T z = depth > 0 ? depth : std::numeric_limits<T>::infinity();
  const T most = allowed > rest ? allowed : rest;  // NaN, where the rest depth is
  return z <= most ? z : rest;
}

/// How far an object stands out of the surface at rest: 0 where it does not touch it or nothing is
/// there, NaN where that or the surface is not known.
template <std::floating_point T>
[[nodiscard]] T protrusion(T depth, T rest, T allowed = 0) {
  if (!is_known(depth) || !is_depth(rest)) return std::numeric_limits<T>::quiet_NaN();
  return rest - contact_depth(depth, rest, allowed);
}

/// The same in a window.
template <std::floating_point T>
void protrusion_into(ImageView<T> out, const Press<T>& press, const Window& window, T allowed = 0) {
  for (Index y = window.top; y < window.bottom; ++y) {
    for (Index x = window.left; x < window.right; ++x) {
      out(x, y) = protrusion(press.depth(x, y), press.rest(x, y), allowed);
    }
  }
}

/// A membrane that has images, asked about others.
inline void require_own_size(Index width, Index height, Index own_width, Index own_height) {
  require(width == own_width && height == own_height, "images of ", width, " x ", height,
          " pixels are not of the membrane's ", own_width, " x ", own_height);
}

}  // namespace gelight::detail

namespace gelight {

/// The depth of a membrane's surface under contact, all of it, without a renderer: NaN where there
/// is no membrane or the depth of the contact is not known (image/mask.hpp tells what depths mean).
/// Throws InvalidInput for images of different sizes, and as the membrane does.
template <ImageLike D, ImageLike R, MembraneModel<ImagePixel<R>> M>
[[nodiscard]] Image<ImagePixel<R>> surface_depth(const M& membrane, const D& depth, const R& rest) {
  using T = ImagePixel<R>;
  detail::require_same_size(depth, rest, "the depth image", "the rest depth image");
  const Index width = static_cast<Index>(ImageTraits<R>::width(rest));
  const Index height = static_cast<Index>(ImageTraits<R>::height(rest));
  Image<T> contact(width, height), untouched(width, height), surface(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      contact(x, y) = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      untouched(x, y) = detail::surface_or_nan(static_cast<T>(ImageTraits<R>::pixel(rest, x, y)));
    }
  }
  auto workspace = membrane.make_workspace(width, height);
  membrane.press_into(surface, Press<T>{contact, untouched, {0, 0, width, height}}, workspace);
  for (std::size_t i = 0; i < surface.pixels().size(); ++i) {
    if (!detail::is_known(contact.pixels()[i])) {
      surface.pixels()[i] = std::numeric_limits<T>::quiet_NaN();
    }
  }
  return surface;
}

}  // namespace gelight
