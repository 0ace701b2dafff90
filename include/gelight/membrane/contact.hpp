#pragma once

#include <concepts>
#include <cstddef>
#include <limits>

#include "gelight/concepts/membrane.hpp"
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

}  // namespace gelight::detail
