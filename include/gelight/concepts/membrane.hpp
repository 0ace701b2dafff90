#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <utility>

#include "gelight/core/types.hpp"

// The seam between a renderer and what its membrane does under contact. A membrane of one's own is
// a class with three functions:
//
//     struct Rigid {  // follows the object exactly
//       struct Workspace {};
//       Index reach() const { return 0; }
//       Workspace make_workspace(Index width, Index height) const { return {}; }
//       void press_into(ImageView<float> surface, const Press<float>& press, Workspace&) const {
//         for (Index y = press.window.top; y < press.window.bottom; ++y) {
//           for (Index x = press.window.left; x < press.window.right; ++x) {
//             const float z = press.depth(x, y), rest = press.rest(x, y);
//             surface(x, y) = z > 0 && z < rest ? z : rest;
//           }
//         }
//       }
//     };
//
// and goes to the renderer: TactileRenderer(camera, rest_depth, Rigid{}, reflectance).
namespace gelight {

template <class P>
class ImageView;

/// The pixels left <= x < right and top <= y < bottom of an image.
struct Window {
  Index left = 0;    ///< first column
  Index top = 0;     ///< first row
  Index right = 0;   ///< behind the last column
  Index bottom = 0;  ///< behind the last row

  /// Whether it holds no pixel.
  [[nodiscard]] bool is_empty() const { return left >= right || top >= bottom; }

  /// The pixels at most `by` columns and rows away that lie in an image; none, if it holds none.
  [[nodiscard]] Window grown(Index by, Index width, Index height) const {
    if (is_empty()) return {};
    by = std::min(by, std::max(width, height));
    return {std::max(Index{0}, left - by), std::max(Index{0}, top - by),
            std::min(width, right + by), std::min(height, bottom + by)};
  }

  /// The pixels that are in both.
  [[nodiscard]] Window common(const Window& other) const {
    return {std::max(left, other.left), std::max(top, other.top), std::min(right, other.right),
            std::min(bottom, other.bottom)};
  }

  /// Whether all four sides are equal.
  friend bool operator==(const Window&, const Window&) = default;
};

/// The reach of a membrane whose surface may depend on the contact anywhere.
inline constexpr Index whole_image = std::numeric_limits<Index>::max();

/// What presses a membrane. All images are of one size, with the pixels of a row side by side.
template <std::floating_point T>
struct Press {
  /// Of what is to touch the membrane; it means what image/mask.hpp says, and what lies deeper than
  /// `rest` does not touch (but see `clips_to_rest` below).
  ImageView<const T> depth;
  ImageView<const T> rest;  ///< of the untouched membrane; NaN where there is none
  Window window;            ///< the pixels of which the surface is asked
};

/// A membrane model: what depth its surface has when something is pressed into it.
///
/// `reach()` is how many columns and rows away, at most, a depth changes the surface, or
/// `whole_image`: farther from any contact the surface is at rest, and what a renderer asks for is
/// no larger than that. `make_workspace(width, height)` makes the memory that one call at a time
/// works in, so that frames need none of their own. `press_into(surface, press, workspace)` writes
/// the surface's depth in the press's window, and no other pixel: the same, bit for bit, whatever
/// the window and whatever was computed before, or a frame would not be the same as in a sequence.
/// Where `rest` is NaN so is the surface; where `depth` is not known, it is where the model takes
/// it to be, or NaN, and then dark beside. Calls may come from several threads, each with a
/// workspace of its own. A model that has images may have `require_fits(camera)`, which throws
/// InvalidInput where they are not of the camera's size; a renderer asks it once. One that is
/// pulled by what lies deeper than the membrane at rest has `clips_to_rest()`, which answers no:
/// else a renderer does not ask it for a surface where nothing is nearer than that.
template <class M, class T>
concept MembraneModel = std::floating_point<T> && requires(const M& membrane, Index size) {
  { membrane.reach() } -> std::convertible_to<Index>;
  membrane.make_workspace(size, size);
} && requires(const M& membrane, ImageView<T> surface, const Press<T>& press,
              decltype(std::declval<const M&>().make_workspace(Index{}, Index{}))& workspace) {
  membrane.press_into(surface, press, workspace);
};

}  // namespace gelight
