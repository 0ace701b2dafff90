#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/membrane/markers.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// As many dots as an image of 4096 x 4096 has pixels, 268 MB of places: more are a mistake in one
/// of two numbers that are multiplied.
inline constexpr std::int64_t most_dots = std::int64_t{1} << 24;

/// Pixels on a grid, row after row: where a gel's dots are. `first` is the column and row of the
/// first, `step` how far the next is along each. Throws InvalidInput, before anything is taken from
/// the heap, for a negative count and for more than `most_dots`.
[[nodiscard]] inline std::vector<Vec2<double>> dot_grid(Index columns, Index rows,
                                                        const Vec2<double>& first,
                                                        const Vec2<double>& step) {
  detail::require(columns >= 0 && rows >= 0, columns, " x ", rows, " dots are a negative count");
  const std::int64_t count = std::int64_t{columns} * rows;
  detail::require(count <= most_dots, columns, " x ", rows, " dots are more than ", most_dots);
  std::vector<Vec2<double>> pixels(static_cast<std::size_t>(count));
  std::size_t i = 0;
  for (Index y = 0; y < rows && columns > 0; ++y) {
    for (Index x = 0; x < columns; ++x) {
      pixels[i++] = {first.x() + x * step.x(), first.y() + y * step.y()};
    }
  }
  return pixels;
}

/// The dots that are printed on a sensor's gel, drawn into its image where the gel takes them.
///
/// A dot is a disc in the membrane's tangent plane at rest; what moves is its outline, point by
/// point, so that it is foreshortened, stretched and bent as the surface is. On a wall so steep
/// that its side is turned away from the camera dots are left out; those on the gel behind such a
/// wall, which it hides too, are drawn over it.
class PrintedDots {
 public:
  /// `rest_depth` in m, or in any unit if `radius` is in the same; `centres` are columns and rows
  /// at rest, or between them; `ink` is the share of each channel's light that a dot leaves. Throws
  /// InvalidInput for a camera that is not valid, a rest depth of another size, a dot outside of
  /// the image or where it or its neighbours have no rest depth, a radius that is not positive and
  /// finite, and ink outside of [0, 1].
  template <std::floating_point T, ImageOf<T> R>
  PrintedDots(const Camera<T>& camera, const R& rest_depth, std::span<const Vec2<double>> centres,
              double radius, const std::array<double, 3>& ink = {0.1, 0.1, 0.1})
      : width_(camera.width),
        height_(camera.height),
        centres_(centres.begin(), centres.end()),
        ink_(ink) {
    camera.require_valid();
    detail::require_camera_size(rest_depth, camera, "the rest depth");
    detail::require_inside<double>("dot", centres, camera.width, camera.height);
    detail::require(radius > 0 && std::isfinite(radius), "the dots' radius ", radius,
                    " is not positive and finite");
    for (const double left : ink) {
      detail::require(left >= 0 && left <= 1, "ink ", left, " is not between 0 and 1");
    }
    const auto eye = camera.template cast<double>();
    for (const auto& centre : centres_) {
      add_outline(eye, centre, radius, [&](Index x, Index y) {
        return static_cast<double>(ImageTraits<R>::pixel(rest_depth, x, y));
      });
    }
  }

  /// Where the dots are at rest: columns and rows.
  [[nodiscard]] const std::vector<Vec2<double>>& centres() const { return centres_; }

  /// Draws the dots on the image of a gel: `field` tells how far a marker moves that was at a pixel
  /// (a function of it, such as DraggedMarkers). Dots that it does not know are left out. Throws
  /// InvalidInput for an image of another size than the camera's.
  template <std::invocable<Vec2<double>> Field>
  void draw_into(ImageView<Rgb8> image, const Field& field) const {
    using namespace detail::arithmetic;
    detail::require(image.width() == width_ && image.height() == height_, "an image of ",
                    image.width(), " x ", image.height(), " pixels is not of the camera's ", width_,
                    " x ", height_);
    std::array<Vec2<double>, corners> outline;
    detail::Array<double> covered(static_cast<std::size_t>(width_));
    for (std::size_t first = 0; first < outlines_.size(); first += corners) {
      bool is_known = true;
      for (std::size_t i = 0; i < corners && is_known; ++i) {
        const Vec2<double>& pixel = outlines_[first + i];
        // Of what lies behind the camera no field is asked.
        if (detail::is_finite(pixel)) outline[i] = pixel + Vec2<double>(field(pixel));
        is_known = detail::is_finite(pixel) && detail::is_finite(outline[i]);
      }
      if (!is_known) continue;
      // Seen from behind it goes round the other way.
      if (area(outline.data()) * area(&outlines_[first]) > 0) fill(image, outline, covered);
    }
  }

  /// The same, for how far every pixel's marker moves, as `marker_displacement` tells it; beyond
  /// the image as at its border. Throws InvalidInput also for a field of another size.
  template <std::floating_point T>
  void draw_into(ImageView<Rgb8> image, const Image<Vec2<T>>& displacement) const {
    detail::require(displacement.width() == width_ && displacement.height() == height_,
                    "a displacement of ", displacement.width(), " x ", displacement.height(),
                    " pixels is not of the camera's ", width_, " x ", height_);
    draw_into(image, [&](const Vec2<double>& pixel) {
      const Vec2<double> inside(std::clamp(pixel.x(), 0.0, width_ - 1.0),
                                std::clamp(pixel.y(), 0.0, height_ - 1.0));
      return detail::between_pixels<double>(width_, height_, inside, [&](Index x, Index y) {
        return cast<double>(displacement(x, y));
      });
    });
  }

  /// Draws the dots of a gel at rest. Throws InvalidInput as above.
  void draw_into(ImageView<Rgb8> image) const {
    draw_into(image, [](const Vec2<double>&) { return Vec2<double>(0, 0); });
  }

 private:
  static constexpr std::size_t corners = 32;
  static constexpr int lines = 8;  // that a row of pixels is cut into

  // Positive for a polygon that goes round from x to y.
  [[nodiscard]] static double area(const Vec2<double>* outline) {
    using namespace detail::arithmetic;
    double twice = 0;
    for (std::size_t i = 0; i < corners; ++i) {
      const Vec2<double> a = outline[i] - outline[0];
      const Vec2<double> b = outline[(i + 1) % corners] - outline[0];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return twice / 2;
  }

  // Of the disc's projection; as many corners as it has, it has its area.
  template <class Depth>
  void add_outline(const Camera<double>& eye, const Vec2<double>& centre, double radius,
                   const Depth& depth) {
    using namespace detail::arithmetic;
    const auto x = static_cast<Index>(std::lround(centre.x()));
    const auto y = static_cast<Index>(std::lround(centre.y()));
    const auto point = [&](Index u, Index v) -> Vec3<double> {
      u = std::clamp(u, Index{0}, width_ - 1);
      v = std::clamp(v, Index{0}, height_ - 1);
      const double z = depth(u, v);
      detail::require(detail::is_depth(z), "dot ", outlines_.size() / corners, " at (", centre.x(),
                      ", ", centre.y(), ") is where the rest depth ", z, " is none");
      return eye.unproject(u, v, z);
    };
    const Vec3<double> here = point(x, y);
    Vec3<double> along = point(x + 1, y) - point(x - 1, y);
    Vec3<double> down = point(x, y + 1) - point(x, y - 1);
    if (width_ == 1) along = {1, 0, 0};
    if (height_ == 1) down = {0, 1, 0};
    const Vec3<double> normal = normalized(cross(along, down));
    along = normalized(along);
    down = cross(normal, along);
    // Where the pixel's ray meets the tangent plane.
    const Vec3<double> ray = eye.ray(centre.x(), centre.y());
    const Vec3<double> middle = dot(here, normal) / dot(ray, normal) * ray;
    constexpr double turn = 2 * std::numbers::pi / corners;
    const double reach = radius * std::sqrt(turn / std::sin(turn));
    for (std::size_t i = 0; i < corners; ++i) {
      const double angle = turn * static_cast<double>(i);
      const Vec3<double> rim = middle + reach * (std::cos(angle) * along + std::sin(angle) * down);
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();
      outlines_.push_back(rim.z() > 0 ? eye.project(rim) : Vec2<double>(nan, nan));
    }
  }

  // Multiplies the pixels in a polygon by the ink, as far as they are covered: exactly along each
  // of a few lines a row.
  void fill(ImageView<Rgb8> image, const std::array<Vec2<double>, corners>& outline,
            detail::Array<double>& covered) const {
    double top = outline[0].y(), bottom = top;
    for (const auto& corner : outline) {
      top = std::min(top, corner.y());
      bottom = std::max(bottom, corner.y());
    }
    // Pixels reach half a pixel around their middles.
    const auto first = static_cast<Index>(std::clamp(std::floor(top + 0.5), 0.0, height_ + 0.0));
    const auto last = static_cast<Index>(std::clamp(std::floor(bottom + 0.5), -1.0, height_ - 1.0));
    std::array<double, corners> crossings;
    for (Index y = first; y <= last; ++y) {
      Index left = width_, right = -1;
      for (int line = 0; line < lines; ++line) {
        const double at = y - 0.5 + (line + 0.5) / lines;
        std::size_t count = 0;
        for (std::size_t i = 0; i < corners; ++i) {
          const auto &a = outline[i], &b = outline[(i + 1) % corners];
          if ((a.y() <= at) == (b.y() <= at)) continue;
          crossings[count++] = a.x() + (at - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        }
        std::make_heap(crossings.data(), crossings.data() + count);
        std::sort_heap(crossings.data(), crossings.data() + count);  // less to compile than sort
        for (std::size_t i = 0; i + 1 < count; i += 2) {
          cover(covered, crossings[i] + 0.5, crossings[i + 1] + 0.5, left, right);
        }
      }
      for (Index x = left; x <= right; ++x) {
        double& share = covered[x];
        Rgb8& pixel = image(x, y);
        for (std::size_t k = 0; k < 3; ++k) {
          const double light = pixel[k] * (1 - std::min(1.0, share) * (1 - ink_[k]));
          pixel[k] = static_cast<std::uint8_t>(std::lround(light));
        }
        share = 0;
      }
    }
  }

  // Adds what a line from one place to another covers of a row's pixels, the first of which begins
  // at 0, and widens the range of those that are covered.
  void cover(detail::Array<double>& covered, double from, double to, Index& left,
             Index& right) const {
    from = std::clamp(from, 0.0, width_ + 0.0);
    to = std::clamp(to, 0.0, width_ + 0.0);
    if (!(from < to)) return;
    const auto begin = static_cast<Index>(from);
    const Index end = std::min(static_cast<Index>(to), width_ - 1);
    for (Index x = begin; x <= end; ++x) {
      covered[x] += (std::min(to, x + 1.0) - std::max(from, x + 0.0)) / lines;
    }
    left = std::min(left, begin);
    right = std::max(right, end);
  }

  Index width_, height_;
  std::vector<Vec2<double>> centres_;
  detail::Array<Vec2<double>> outlines_;
  std::array<double, 3> ink_;
};

}  // namespace gelight
