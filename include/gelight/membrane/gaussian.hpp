#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/smoothing.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// The membrane of the GelTip, pressed in by whatever is nearer than its rest depth, which bulges
/// around it by a Gaussian G of the protrusion: min(depth, rest - G(rest - depth)). Depths that are
/// not known are left out of the Gaussian's mean. (Gomes, Paoletti, Luo 2023,
/// doi:10.15607/RSS.2023.XIX.035)
///
/// A renderer computes it row by row while they are in cache, and for no other membrane is a frame
/// faster; `press_into` costs 4 radius + 2 multiply-adds a pixel of the window.
template <std::floating_point T>
class GaussianMembrane {
 public:
  /// Standard deviation of the Gaussian and where it is cut off, in pixels; 0 is a membrane that
  /// follows the object exactly. `clip_to_rest` takes what lies deeper than the membrane at rest as
  /// not touching it, rather than as pulling it. Throws InvalidInput as gaussian_weights does.
  explicit GaussianMembrane(double sigma = 5, Index radius = 20, bool clip_to_rest = true)
      : weights_(gaussian_weights<T>(sigma, radius)), clip_to_rest_(clip_to_rest) {
    if (sigma == 0) weights_.resize(1);
  }

  /// Half of the Gaussian's weights, from its middle outwards.
  [[nodiscard]] const std::vector<T>& weights() const { return weights_; }
  /// Whether what lies deeper than the membrane at rest does not touch it.
  [[nodiscard]] bool clips_to_rest() const { return clip_to_rest_; }

  /// The memory that `press_into` works in.
  struct Workspace {
    detail::Smoother<T> smoother;  ///< for images of this size
    Image<T> protrusion;           ///< of the object
  };

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const { return static_cast<Index>(weights_.size()) - 1; }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    return {detail::Smoother<T>(width, height, reach()), Image<T>(width, height)};
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    const T allowed = clip_to_rest_ ? T(0) : std::numeric_limits<T>::max();
    const Window& window = press.window;
    const Window near = window.grown(reach(), surface.width(), surface.height());
    detail::protrusion_into<T>(work.protrusion, press, near, allowed);
    if (reach() > 0) work.smoother.mean_into(surface, work.protrusion, window, weights_);
    for (Index y = window.top; y < window.bottom; ++y) {
      for (Index x = window.left; x < window.right; ++x) {
        const T rest = press.rest(x, y);
        const T contact = detail::contact_depth(press.depth(x, y), rest, allowed);
        surface(x, y) = reach() > 0 ? std::min(rest - surface(x, y), contact) : contact;
      }
    }
  }
  ///@}

 private:
  std::vector<T> weights_;
  bool clip_to_rest_;
};

}  // namespace gelight
