#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/views/image_view.hpp"

// How far the dots that are printed on a gel move in the camera's image.

namespace gelight {

/// A dragged contact's markers in closed form: about a centre that moves by `shift` each dot r away
/// moves by
///     reach (shift / rho + stretch r (r . shift) / rho^3),   rho^2 = |r|^2 + reach^2,
/// the far field of a sideways force on a half-space (Cerruti's; Johnson, Contact Mechanics, 1985,
/// doi:10.1017/CBO9781139171731, section 3.6) made round at the centre. Everything in pixels.
struct DraggedMarkers {
  Vec2<double> centre{0, 0};  ///< column and row
  Vec2<double> shift{0, 0};   ///< of what touches the gel
  double reach = 1;           ///< see `of_disc`
  double stretch = 0;         ///< see `of_disc`

  /// Those of a disc that sticks to a half-space: far away the same as Mindlin's exact solution
  /// (Compliance of elastic bodies in contact, 1949, doi:10.1115/1.4009973). Radius in pixels.
  /// Throws InvalidInput for a radius that is not positive and finite, a Poisson ratio outside of
  /// [0, 0.5], and as require_valid does.
  [[nodiscard]] static DraggedMarkers of_disc(const Vec2<double>& centre, const Vec2<double>& shift,
                                              double radius, double poisson_ratio) {
    detail::require(radius > 0 && std::isfinite(radius), "radius ", radius,
                    " is not positive and finite");
    detail::require(poisson_ratio >= 0 && poisson_ratio <= 0.5, "Poisson ratio ", poisson_ratio,
                    " is not between 0 and 0.5");
    const double nu = poisson_ratio;
    DraggedMarkers markers{centre, shift, 4 * radius * (1 - nu) / (std::numbers::pi * (2 - nu)),
                           nu / (1 - nu)};
    markers.require_valid();
    return markers;
  }

  /// Throws InvalidInput for a reach that is not positive or whose square no double holds, and for
  /// a centre, a shift and a stretch that are not finite.
  void require_valid() const {
    detail::require(detail::is_finite(centre), "centre (", centre.x(), ", ", centre.y(),
                    ") is not finite");
    detail::require(detail::is_finite(shift), "shift (", shift.x(), ", ", shift.y(),
                    ") is not finite");
    detail::require(reach > 0 && std::isfinite(reach), "reach ", reach,
                    " is not positive and finite");
    detail::require(std::isnormal(reach * reach), "reach ", reach, " has a square that no double",
                    " holds");
    detail::require(std::isfinite(stretch), "stretch ", stretch, " is not finite");
  }

  /// How far a marker moves that was at a pixel. Throws InvalidInput as require_valid does.
  [[nodiscard]] Vec2<double> operator()(const Vec2<double>& pixel) const {
    require_valid();
    const double x = pixel.x() - centre.x(), y = pixel.y() - centre.y();
    const double square = x * x + y * y + reach * reach, near = reach / std::sqrt(square);
    const double along = stretch * (x * shift.x() + y * shift.y()) / square;
    return {near * (shift.x() + along * x), near * (shift.y() + along * y)};
  }
};

/// Three Gaussians that are fitted to a sensor: dots that are touched push the others away, and
/// drag and turn them along (Zhao, Qian, Duan, Luo, FOTS: A Fast Optical Tactile Simulator for
/// Sim2Real Learning of Tactile-motor Robot Manipulation Skills, 2024,
/// doi:10.48550/arXiv.2404.19217). For comparison. Everything in pixels.
struct GaussianMarkers {
  /// A dot that is touched.
  struct Touched {
    Vec2<double> pixel;  ///< where it is: column and row
    /// How far each pixel away from it is pushed, close by, in proportion to its depth.
    double push;
  };
  std::vector<Touched> touched;  ///< all dots that are touched
  Vec2<double> centre{0, 0};     ///< of the object: column and row
  Vec2<double> shift{0, 0};      ///< of the object
  double twist = 0;              ///< of the object, in radians from x to y
  double push_decay = 0;         ///< of what is pushed, per square of pixels
  double shift_decay = 0;        ///< of what is dragged along, per square of pixels
  double twist_decay = 0;        ///< of what is turned along, per square of pixels

  /// Throws InvalidInput for a decay that is negative or not finite, and for a touched dot, a
  /// centre, a shift and a twist that are not finite.
  void require_valid() const {
    for (const double decay : {push_decay, shift_decay, twist_decay}) {
      detail::require(decay >= 0 && std::isfinite(decay), "decays ", push_decay, ", ", shift_decay,
                      " and ", twist_decay, " of push, shift and twist: ", decay,
                      " is negative or not finite");
    }
    detail::require(detail::is_finite(centre), "centre (", centre.x(), ", ", centre.y(),
                    ") is not finite");
    detail::require(detail::is_finite(shift), "shift (", shift.x(), ", ", shift.y(),
                    ") is not finite");
    detail::require(std::isfinite(twist), "twist ", twist, " is not finite");
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const auto& [dot, push] = touched[i];
      detail::require(detail::is_finite(dot) && std::isfinite(push), "touched dot ", i, " at (",
                      dot.x(), ", ", dot.y(), ") with push ", push, " is not finite");
    }
  }

  /// How far a marker moves that was at a pixel. Throws InvalidInput as require_valid does.
  [[nodiscard]] Vec2<double> operator()(const Vec2<double>& pixel) const {
    require_valid();
    double along = 0, down = 0;
    for (const Touched& dot : touched) {
      const double x = pixel.x() - dot.pixel.x(), y = pixel.y() - dot.pixel.y();
      const double push = dot.push * std::exp(-push_decay * (x * x + y * y));
      along += push * x;
      down += push * y;
    }
    const double x = pixel.x() - centre.x(), y = pixel.y() - centre.y(), square = x * x + y * y;
    const double drag = std::exp(-shift_decay * square), turn = std::exp(-twist_decay * square);
    const double cos = std::cos(twist) - 1, sin = std::sin(twist);
    along += drag * shift.x();
    down += drag * shift.y();
    return {along + turn * (cos * x - sin * y), down + turn * (sin * x + cos * y)};
  }
};

/// How far every pixel's marker moves, in pixels, by a closed form: a function of the pixel such as
/// DraggedMarkers. Throws InvalidInput for a negative size.
template <std::floating_point T, std::invocable<Vec2<double>> Field>
[[nodiscard]] Image<Vec2<T>> marker_displacement(Index width, Index height, const Field& field) {
  Image<Vec2<T>> moved(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const Vec2<double> by = field(Vec2<double>(x, y));
      moved(x, y) = cast<T>(by);
    }
  }
  return moved;
}

namespace detail {

/// How far in the image a point at rest moves that a pixel sees, NaN where that is not known.
template <std::floating_point T>
[[nodiscard]] Vec2<T> moved_pixel(const Camera<T>& camera, Index x, Index y, T rest,
                                  const Vec3<T>& by) {
  constexpr T nan = std::numeric_limits<T>::quiet_NaN();
  const T depth = rest + by.z();
  if (!(rest > 0 && depth > 0) || !std::isfinite(depth) || !is_finite(by)) return {nan, nan};
  // The difference of the two projections, without the digits that it would lose.
  const Vec3<T> ray = camera.ray(static_cast<T>(x), static_cast<T>(y));
  return {camera.fx * (by.x() - ray.x() * by.z()) / depth,
          camera.fy * (by.y() - ray.y() * by.z()) / depth};
}

/// `value(x, y)` between pixels of an image, bilinearly.
template <std::floating_point T, class Value>
[[nodiscard]] Vec2<T> between_pixels(Index width, Index height, const Vec2<T>& pixel,
                                     const Value& value) {
  const auto left = static_cast<Index>(pixel.x()), top = static_cast<Index>(pixel.y());
  const T s = pixel.x() - static_cast<T>(left), t = pixel.y() - static_cast<T>(top);
  // No pixel that has no weight, as its value may be NaN.
  const Index right = s > 0 ? std::min(left + 1, width - 1) : left;
  const Index bottom = t > 0 ? std::min(top + 1, height - 1) : top;
  return (1 - t) * ((1 - s) * value(left, top) + s * value(right, top)) +
         t * ((1 - s) * value(left, bottom) + s * value(right, bottom));
}

template <std::floating_point T>
void require_inside(const char* what, std::span<const Vec2<T>> pixels, Index width, Index height) {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Vec2<T>& pixel = pixels[i];
    require(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= static_cast<T>(width - 1) &&
                pixel.y() <= static_cast<T>(height - 1),
            what, " ", i, " at (", pixel.x(), ", ", pixel.y(), ") is outside of the image");
  }
}

}  // namespace detail

/// How far every pixel's marker moves, in pixels, when the point of the gel that it marks moves:
/// `rest_depth` in m, `displacement` of the gel's points in the camera's frame, m, as of an
/// ElasticLayer's contact. NaN where either is not known. Throws InvalidInput for a camera that is
/// not valid and images of other sizes.
template <std::floating_point T, ImageOf<T> R, ImageLike D>
[[nodiscard]] Image<Vec2<T>> marker_displacement(const Camera<T>& camera, const R& rest_depth,
                                                 const D& displacement) {
  camera.require_valid();
  detail::require_camera_size(rest_depth, camera, "the rest depth");
  detail::require_camera_size(displacement, camera, "the displacement");
  Image<Vec2<T>> moved(camera.width, camera.height);
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) {
      moved(x, y) = detail::moved_pixel<T>(camera, x, y,
                                           static_cast<T>(ImageTraits<R>::pixel(rest_depth, x, y)),
                                           ImageTraits<D>::pixel(displacement, x, y));
    }
  }
  return moved;
}

/// The same of the markers at given pixels alone (columns and rows between them, too): bilinear
/// between the four pixels around each, a few operations a marker. Throws InvalidInput also for a
/// marker outside of the image.
template <std::floating_point T, ImageOf<T> R, ImageLike D>
[[nodiscard]] std::vector<Vec2<T>> marker_displacement(
    const Camera<T>& camera, const R& rest_depth, const D& displacement,
    std::type_identity_t<std::span<const Vec2<T>>> pixels) {
  camera.require_valid();
  detail::require_camera_size(rest_depth, camera, "the rest depth");
  detail::require_camera_size(displacement, camera, "the displacement");
  detail::require_inside<T>("marker", pixels, camera.width, camera.height);
  std::vector<Vec2<T>> moved;
  moved.reserve(pixels.size());
  for (const Vec2<T>& pixel : pixels) {
    moved.push_back(
        detail::between_pixels<T>(camera.width, camera.height, pixel, [&](Index x, Index y) {
          return detail::moved_pixel<T>(camera, x, y,
                                        static_cast<T>(ImageTraits<R>::pixel(rest_depth, x, y)),
                                        ImageTraits<D>::pixel(displacement, x, y));
        }));
  }
  return moved;
}

/// How far markers move that were at the given pixels (columns and rows between them, too): an
/// image's values, interpolated bilinearly. Throws InvalidInput for a marker outside of the image.
template <std::floating_point T>
[[nodiscard]] std::vector<Vec2<T>> sample_markers(const Image<Vec2<T>>& displacement,
                                                  std::span<const Vec2<T>> pixels) {
  detail::require_inside<T>("marker", pixels, displacement.width(), displacement.height());
  std::vector<Vec2<T>> moved;
  moved.reserve(pixels.size());
  for (const Vec2<T>& pixel : pixels) {
    moved.push_back(
        detail::between_pixels<T>(displacement.width(), displacement.height(), pixel,
                                  [&](Index x, Index y) { return displacement(x, y); }));
  }
  return moved;
}

}  // namespace gelight
