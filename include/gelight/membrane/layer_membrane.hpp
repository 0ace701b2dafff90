#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <utility>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/views/image_view.hpp"

// Opt-in: includes Eigen's unsupported FFT.

namespace gelight {

/// An elastic layer as a renderer's membrane: what is seen in it is pressed in, or whatever touches
/// it is pressed in by a force. Some 20 convolutions and memory from the heap for every frame; for
/// the surface alone BulgingMembrane is far cheaper.
///
/// The layer's rest depth is to be that of the renderer, to a hundredth of a pixel's width, and
/// known wherever that is. Where the object's depth is not known, nothing touches. A frame throws
/// InvalidInput for another rest depth, as
/// ElasticLayer::press does, and for a contact that is off by more than `most_residual` of the
/// deepest press. A model of the concept MembraneModel, but for what `warm` says.
template <std::floating_point T>
class LayerMembrane {
 public:
  /// How far off a contact that has not converged may be to be shown: hardly to be seen.
  static constexpr double most_residual = 0.05;

  /// `load` as ElasticLayer::press takes it, which throws in a frame for one that cannot be; leave
  /// `sideways` out of the layer's options, unless the displacement is looked at.
  ///
  /// `warm` starts each contact from the last of the same workspace. That saves convolutions where
  /// objects move little from frame to frame; a frame then depends on those before it, by up to
  /// about twice the layer's tolerance: with and without them it is off by up to about one.
  explicit LayerMembrane(ElasticLayer<T> layer, const LayerLoad& load = {}, bool warm = false)
      : layer_(std::move(layer)), load_(load), is_warm_(warm) {}

  /// The memory that `press_into` works in.
  struct Workspace {
    Image<T> depth;                          ///< of the object, where known
    std::optional<LayerContact<T>> contact;  ///< of the last frame
  };

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const { return whole_image; }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    const Image<T>& own = layer_.rest_depth();
    detail::require_own_size(width, height, own.width(), own.height());
    return {Image<T>(width, height), {}};
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    for (Index y = 0; y < work.depth.height(); ++y) {
      for (Index x = 0; x < work.depth.width(); ++x) {
        const T z = press.depth(x, y);
        work.depth(x, y) = detail::is_known(z) ? z : std::numeric_limits<T>::infinity();
      }
    }
    require_same_rest(press);
    const bool has_last = is_warm_ && work.contact.has_value();
    work.contact = layer_.press(work.depth, load_, has_last ? &*work.contact : nullptr);
    if (!work.contact->converged && !(work.contact->residual <= most_residual)) {
      const double residual = work.contact->residual;
      work.contact.reset();
      detail::refuse({"the layer's contact did not converge: it is off by ", residual,
                      " of the deepest press"});
    }
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const T rest = press.rest(x, y);
        surface(x, y) = std::isnan(rest) ? rest : work.contact->depth(x, y);
      }
    }
  }
  /// Throws InvalidInput for a camera of another size.
  void require_fits(const Camera<T>& camera) const {
    const Image<T>& own = layer_.rest_depth();
    detail::require_own_size(camera.width, camera.height, own.width(), own.height());
  }
  ///@}

 private:
  // To a hundredth of a pixel's width: it may have been found in another way.
  void require_same_rest(const Press<T>& press) const {
    const double most = 0.01 * layer_.pixel().minCoeff();
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const T seen = press.rest(x, y), own = layer_.rest_depth()(x, y);
        const bool is_same = std::abs(double{seen} - double{own}) <= most;  // no, where it is NaN
        detail::require(is_same || std::isnan(seen), "at pixel (", x, ", ", y,
                        ") the renderer's rest depth is ", seen, " m, the layer's ", own, " m");
      }
    }
  }

  ElasticLayer<T> layer_;
  LayerLoad load_;
  bool is_warm_;
};

static_assert(MembraneModel<LayerMembrane<float>, float>);

}  // namespace gelight
