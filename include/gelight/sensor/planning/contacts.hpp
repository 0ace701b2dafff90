#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// An object that is pressed into a membrane, in a window of the camera's image.
struct TrialContact {
  Window window;        ///< of the pixels that count, and around it as far as a depth reaches
  Image<double> depth;  ///< of the object there
  Window counted;       ///< the pixels that count, in the window
  double weight = 1;    ///< how many pixels each of them stands for
  Index across = 0;     ///< columns that it stands in the membrane in
  Index down = 0;       ///< rows
  Image<double> whole;  ///< the object's depth in all of the camera's image
  double slant = 0;     ///< radians, of the membrane there from across the camera's axis

  /// The pixels that are lit, in the window: those that count and what their normals need.
  [[nodiscard]] Window lit_in_window() const {
    return counted.grown(2, window.right - window.left, window.bottom - window.top);
  }
  /// The same in the camera's image.
  [[nodiscard]] Window lit() const { return moved(lit_in_window(), window.left, window.top); }
  /// The pixels that count, in those that are lit.
  [[nodiscard]] Window counted_in_lit() const {
    const Window near = lit_in_window();
    return moved(counted, -near.left, -near.top);
  }

 private:
  [[nodiscard]] static Window moved(const Window& w, Index across, Index down) {
    return {w.left + across, w.top + down, w.right + across, w.bottom + down};
  }
};

/// Draws contacts: balls and, at a slant of up to 0.2 radians, boxes in turn, each where a pixel
/// chosen by lot sees the membrane.
class ContactDraw {
 public:
  /// Of contacts that would have this radius and depth on a flat membrane, in m.
  ContactDraw(const Surface<double>& membrane, const Camera<double>& camera,
              const Raster<double>& rest, double radius, double depth, std::uint64_t seed)
      : membrane_(membrane),
        camera_(camera),
        rest_(rest),
        radius_(radius),
        depth_(depth),
        random_(seed) {
    double farthest = 0;
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        if (rest.face(x, y) < 0) continue;
        seen_.push_back({x, y});
        farthest = std::max(farthest, rest.depth(x, y));
      }
    }
    require(!seen_.empty(), "the camera does not see the membrane");
    require(depth < farthest, "contacts of depth ", depth, " go behind the camera, from which the ",
            "membrane is ", farthest, " away at most");
    require(std::max(ball_size(), radius_) <= largest_object, "contacts of radius ", radius_,
            " and depth ", depth_, " are too flat or too large to be balls and boxes");
  }

  /// The next one: of the pixels at most `around` from it no more than a square of some, drawn by
  /// lot, and what is at most `reach` from those. Throws InvalidInput where 100 in a row stand in
  /// the membrane in fewer than 16 pixels.
  [[nodiscard]] TrialContact next(Index around, Index reach) {
    for (int attempt = 0; attempt < 100; ++attempt) {
      const bool is_ball = ++drawn_ % 2 == 1;
      const Place place = drawn_place();
      const Mesh<double> object = is_ball ? ball() : box_at_slant();
      const Image<double> depth = rasterize(object, camera_, place).depth;
      Window touched{camera_.width, camera_.height, 0, 0};
      Index count = 0;
      for (const auto& [x, y] : seen_) {
        if (!(depth(x, y) > 0 && depth(x, y) < rest_.depth(x, y))) continue;
        touched = {std::min(touched.left, x), std::min(touched.top, y),
                   std::max(touched.right, x + 1), std::max(touched.bottom, y + 1)};
        ++count;
      }
      if (count < fewest_pixels) continue;
      const Window near = touched.grown(around, camera_.width, camera_.height);
      const auto [left, right, across] = drawn_part(near.left, near.right);
      const auto [top, bottom, down] = drawn_part(near.top, near.bottom);
      const Window counted{left, top, right, bottom};
      const Window window = counted.grown(reach + 3, camera_.width, camera_.height);
      TrialContact contact{window,
                           Image<double>(window.right - window.left, window.bottom - window.top),
                           {counted.left - window.left, counted.top - window.top,
                            counted.right - window.left, counted.bottom - window.top},
                           double(across) * double(down),
                           touched.right - touched.left,
                           touched.bottom - touched.top,
                           depth,
                           std::acos(std::clamp(place.frame(2, 2), -1.0, 1.0))};
      for (Index y = window.top; y < window.bottom; ++y) {
        for (Index x = window.left; x < window.right; ++x) {
          contact.depth(x - window.left, y - window.top) = depth(x, y);
        }
      }
      return contact;
    }
    refuse({"contacts of radius ", radius_, " and depth ", depth_, " cover less than ",
            fewest_pixels, " pixels"});
  }

 private:
  static constexpr int fewest_pixels = 16;
  static constexpr double largest_object = 1e100;  // m: squares of its vertices are numbers
  static constexpr Index side = 40;                // of the square, at most

  struct Place {
    Eigen::Matrix3d frame;  // its z away from the camera, at right angles to the membrane
    Vec3<double> point;
  };

  [[nodiscard]] double uniform(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(random_() >> 11), -53);
  }

  // One of the parts, as wide as each other but for a pixel, that a range is cut into, and how many
  // they are. Each is as likely as the others, so that no pixel counts for more than another: of
  // squares that begin anywhere hardly one would reach the range's ends, where the image ends too
  // and its light is nearest.
  struct Part {
    Index begin, end, count;
  };
  [[nodiscard]] Part drawn_part(Index low, Index high) {
    const Index count = (high - low + side - 1) / side;
    if (count <= 1) return {low, high, 1};
    const auto drawn = static_cast<Index>(uniform(0, static_cast<double>(count)));
    const Index k = std::min(drawn, count - 1);
    const auto begin_of = [&](Index part) { return low + part * (high - low) / count; };
    return {begin_of(k), begin_of(k + 1), count};
  }

  // Objects have what touches first at the origin, and their bodies towards z.
  [[nodiscard]] double ball_size() const {
    return (radius_ * radius_ + depth_ * depth_) / (2 * depth_);
  }
  [[nodiscard]] Mesh<double> ball() const {
    const double size = ball_size();
    return placed<double>(icosphere<double>(4, size), Eigen::Matrix3d::Identity(), {0, 0, size});
  }
  [[nodiscard]] Mesh<double> box_at_slant() {
    const double edge = std::numbers::sqrt2 * radius_;
    const double slant = uniform(0, 0.2), about = uniform(0, 2 * std::numbers::pi);
    const Vec3<double> up(std::sin(slant) * std::cos(about), std::sin(slant) * std::sin(about),
                          std::cos(slant));
    const Mesh<double> turned = placed<double>(box(edge, edge, edge), frame_of(up, 0), {0, 0, 0});
    double lowest = 0;
    for (const auto& p : turned.positions) lowest = std::min(lowest, p[2]);
    return placed<double>(turned, Eigen::Matrix3d::Identity(), {0, 0, -lowest});
  }

  [[nodiscard]] Place drawn_place() {
    const auto at = static_cast<std::size_t>(uniform(0, static_cast<double>(seen_.size())));
    const auto [x, y] = seen_[std::min(at, seen_.size() - 1)];
    const Vec3<double> ray = camera_.ray(x, y);
    Vec3<double> out = stable_unit(face_normal(membrane_, rest_.face(x, y)));
    if (dot(out, ray) < 0) out = -out;
    return {frame_of(out, uniform(0, 2 * std::numbers::pi)),
            rest_.depth(x, y) * ray - depth_ * out};
  }

  // A frame with this z axis.
  [[nodiscard]] static Eigen::Matrix3d frame_of(const Vec3<double>& z, double turn) {
    const Vec3<double> u = unit_orthogonal(z), v = cross(z, u);
    const Vec3<double> x = std::cos(turn) * u + std::sin(turn) * v;
    Eigen::Matrix3d frame;
    frame << x, cross(z, x), z;
    return frame;
  }

  [[nodiscard]] static Raster<double> rasterize(const Mesh<double>& object,
                                                const Camera<double>& camera, const Place& place) {
    return gelight::rasterize(placed<double>(object, place.frame, place.point), camera);
  }

  const Surface<double>& membrane_;
  const Camera<double>& camera_;
  const Raster<double>& rest_;
  double radius_, depth_;
  std::mt19937_64 random_;
  std::uint64_t drawn_ = 0;
  std::vector<std::array<Index, 2>> seen_;
};

}  // namespace gelight::detail
