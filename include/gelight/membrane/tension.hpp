#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A membrane under tension on an elastic foundation: beside an object its slope goes on and decays
/// over a length. What calibrate() fits to photographs, for any object and for the renderer. The
/// gel goes on beyond the image, where what leaves it decays over that length.
///
/// Solves w - length^2 laplace(w) = p, p >= 0, w >= u, p (w - u) = 0 for the height w of the
/// surface over rest, with u the object's, by over-relaxed sweeps projected onto w >= u (Cryer, The
/// solution of a quadratic programming problem using systematic overrelaxation, 1971,
/// doi:10.1137/0309028), until no pixel moves by more than a share of 1e-6 of the highest. Some
/// three sweeps over the image for every pixel of the length.
template <std::floating_point T>
class TensionMembrane {
 public:
  /// The length in pixels. Throws InvalidInput where it is not positive, or more than 1000.
  explicit TensionMembrane(double length) : length_(length) {
    detail::require(length > 0 && length <= 1000, "tension length ", length,
                    " is not positive, or more than 1000 pixels");
  }

  /// Over what length a bulge decays.
  [[nodiscard]] double length() const { return length_; }
  /// As concepts/membrane.hpp says.
  [[nodiscard]] Index reach() const { return whole_image; }

  struct Workspace {
    std::vector<double> height, object;
  };
  /// As concepts/membrane.hpp says.
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    const std::vector<double> image(static_cast<std::size_t>(width + 2) *
                                    static_cast<std::size_t>(height + 2));
    return {image, image};
  }

  /// As concepts/membrane.hpp says.
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    const Index width = press.depth.width(), height = press.depth.height();
    take_in(press, work);
    relax(work, width, height);
    const std::ptrdiff_t stride = width + 2;
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const std::ptrdiff_t i = (y + 1) * stride + x + 1;
        const double w = work.height[static_cast<std::size_t>(i)];
        // Where the object touches, its own depth, not one rounded on the way.
        surface(x, y) = w <= work.object[static_cast<std::size_t>(i)]
                            ? press.depth(x, y)
                            : press.rest(x, y) - static_cast<T>(w);
      }
    }
  }

 private:
  void take_in(const Press<T>& press, Workspace& work) const {
    std::fill(work.height.begin(), work.height.end(), 0.0);
    const std::ptrdiff_t stride = press.depth.width() + 2;
    for (Index y = 0; y < press.depth.height(); ++y) {
      for (Index x = 0; x < press.depth.width(); ++x) {
        const T z = press.depth(x, y), rest = press.rest(x, y);
        const auto i = static_cast<std::size_t>((y + 1) * stride + x + 1);
        const bool is_there = z > 0 && std::isfinite(z) && detail::is_depth(rest);
        work.object[i] =
            is_there ? double{rest} - double{z} : -std::numeric_limits<double>::infinity();
        work.height[i] = std::max(0.0, work.object[i]);
      }
    }
  }

  // Red and black pixels in turn; beyond the border the surface decays as a straight bulge does.
  void relax(Workspace& work, Index width, Index height) const {
    const double square = length_ * length_, share = square / (1 + 4 * square);
    const double beyond = std::exp(-1 / length_);
    const double jacobi = 4 * share;
    const double relaxation = 2 / (1 + std::sqrt(1 - jacobi * jacobi));
    const std::ptrdiff_t stride = width + 2;
    double* const w = work.height.data();
    const double* const u = work.object.data();
    for (int sweep = 0; sweep < 20000; ++sweep) {
      double change = 0, highest = 0;
      for (Index x = 1; x <= width; ++x) {
        w[x] = beyond * w[stride + x];
        w[(height + 1) * stride + x] = beyond * w[height * stride + x];
      }
      for (Index y = 1; y <= height; ++y) {
        double* const row = w + y * stride;
        row[0] = beyond * row[1];
        row[width + 1] = beyond * row[width];
      }
      for (const Index colour : {0, 1}) {
        for (Index y = 1; y <= height; ++y) {
          double* const row = w + y * stride;
          for (Index x = 1 + (y + colour) % 2; x <= width; x += 2) {
            const double mean =
                share * (row[x - 1] + row[x + 1] + row[x - stride] + row[x + stride]);
            const double next = std::max(row[x] + relaxation * (mean - row[x]), u[y * stride + x]);
            change = std::max(change, std::abs(next - row[x]));
            highest = std::max(highest, next);
            row[x] = next;
          }
        }
      }
      if (change <= 1e-6 * highest) return;
    }
  }

  double length_;
};

}  // namespace gelight
