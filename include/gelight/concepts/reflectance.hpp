#pragma once

#include <concepts>
#include <cstddef>

#include "gelight/core/types.hpp"

// The seam between a renderer and how its membrane shines. A reflectance of one's own is a class
// with one function:
//
//     struct NormalMap {  // red where the surface leans right, green where it leans down
//       void shade_row(const ColourRow<float>& out, const SurfaceRow<float>& row) const {
//         for (std::ptrdiff_t i = 0; i < row.count; ++i) {
//           out.r[i] = (1 + row.nx[i]) / 2;
//           out.g[i] = (1 + row.ny[i]) / 2;
//           out.b[i] = (1 - row.nz[i]) / 2;
//         }
//       }
//     };
//
// and goes to the renderer: TactileRenderer(camera, rest_depth, membrane, NormalMap{}).
namespace gelight {

/// How many pixels a SurfaceRow has at most.
inline constexpr Index longest_surface_row = 64;

/// Pixels side by side, and what of the membrane is seen there. Arrays begin with the first of
/// them.
template <std::floating_point T>
struct SurfaceRow {
  Index x;               ///< column of the first pixel
  Index y;               ///< its row
  std::ptrdiff_t count;  ///< how many there are: at most `longest_surface_row`
  /// Unit normals towards the camera, in its frame; zero: not known, as at the image's border
  /// unless `FrameOptions::border_normals` tells otherwise.
  const T* nx;
  const T* ny;  ///< their second
  const T* nz;  ///< and third coordinates
  /// The share of the ambient light that is left where the gel is pressed in; null: all of it.
  const T* kept;
  /// Not zero where an object touches the gel; null unless the reflectance has a member
  /// `static constexpr bool reads_touched = true`.
  const T* touched = nullptr;
};

/// Where colours are written to: linear red, green and blue in shares of full light; what is not
/// between 0 and 1 is clamped. The arrays overlap nothing.
template <std::floating_point T>
struct ColourRow {
  T* __restrict r;  ///< red
  T* __restrict g;  ///< green
  T* __restrict b;  ///< blue
};

/// A reflectance: the colour of the membrane from its normal and pixel, a row at a time, so that
/// compilers vectorise it.
///
/// `shade_row(out, row)` writes `row.count` colours. A pixel's colour depends on nothing but its
/// normal, place, `kept` and `touched`. Where the normal is zero it is that of ambient light alone.
/// A model that has images may have `require_fits(camera)`, which throws InvalidInput where they
/// are not of the camera's size; a renderer asks it once. Calls may come from several threads.
template <class R, class T>
concept Reflectance = std::floating_point<T> &&
    requires(const R& model, const ColourRow<T>& out, const SurfaceRow<T>& row) {
  model.shade_row(out, row);
};

}  // namespace gelight
