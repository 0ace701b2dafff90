#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/smoothing.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// The membrane of Taxim: the protrusion blurred by one Gaussian after the other, and put back
/// after each wherever the object is. Depths that are not known are left out of the Gaussians'
/// means. (Si, Yuan, Taxim: An Example-based Simulation Model for GelSight Tactile Sensors, 2022,
/// doi:10.1109/LRA.2022.3142412)
///
/// A frame costs the sum of 16 sigma + 2 multiply-adds a pixel of the contact, grown by the reach.
template <std::floating_point T>
class PyramidMembrane {
 public:
  /// The Gaussians' standard deviations in pixels, in the order in which they are applied; each is
  /// cut off at 4 sigma. Throws InvalidInput for a sigma that is not between 0 and 1e6, and for
  /// sigmas that together reach more pixels than can be counted.
  explicit PyramidMembrane(std::span<const double> sigmas) {
    double reach = 0;
    for (const double sigma : sigmas) {
      detail::require(std::isfinite(sigma) && sigma >= 0 && sigma <= most_sigma, "sigma ", sigma,
                      " is not between 0 and ", most_sigma);
      reach += std::ceil(4 * sigma);
    }
    // Before any weights are made: so many would fill gigabytes.
    detail::require(reach < whole_image, sigmas.size(), " sigmas reach ", reach,
                    " pixels together, more than can be counted");
    for (const double sigma : sigmas) {
      levels_.push_back(gaussian_weights<T>(sigma, static_cast<Index>(std::ceil(4 * sigma))));
    }
  }

  /// The memory that `press_into` works in.
  struct Workspace {
    detail::Smoother<T> smoother;  ///< for images of this size
    Image<T> protrusion;           ///< of the object
    Image<T> gel;                  ///< the protrusion, blurred so far
    Image<T> blurred;              ///< the same once more
  };

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const {
    Index sum = 0;
    for (const auto& weights : levels_) sum += radius(weights);
    return sum;
  }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    Index most = 0;
    for (const auto& weights : levels_) most = std::max(most, radius(weights));
    const Image<T> image(width, height);
    return {detail::Smoother<T>(width, height, most), image, image, image};
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    const auto grown = [&](Index by) {
      return press.window.grown(by, surface.width(), surface.height());
    };
    Index left = reach();  // what the Gaussians still to come will read around the window
    const Window near = grown(left);
    detail::protrusion_into<T>(work.protrusion, press, near);
    for_each(near, [&](Index x, Index y) {
      work.gel(x, y) = work.protrusion(x, y);
      work.blurred(x, y) = 0;
    });
    for (const auto& weights : levels_) {
      left -= radius(weights);
      work.smoother.mean_into(work.blurred, work.gel, grown(left), weights);
      for_each(grown(left), [&](Index x, Index y) {
        const T own = work.protrusion(x, y);
        work.gel(x, y) = own == 0 ? work.blurred(x, y) : own;
      });
    }
    for_each(press.window, [&](Index x, Index y) {
      const T gel = work.gel(x, y);
      surface(x, y) = press.rest(x, y) - (std::isnan(gel) ? work.blurred(x, y) : gel);
    });
  }
  ///@}

 private:
  static constexpr double most_sigma = 1e6;

  [[nodiscard]] static Index radius(const std::vector<T>& weights) {
    return static_cast<Index>(weights.size()) - 1;
  }
  template <class Work>
  static void for_each(const Window& window, const Work& work) {
    for (Index y = window.top; y < window.bottom; ++y) {
      for (Index x = window.left; x < window.right; ++x) work(x, y);
    }
  }

  std::vector<std::vector<T>> levels_;
};

}  // namespace gelight
