#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <utility>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A bed of springs as a renderer's membrane: whatever touches it is pressed in by a force until
/// the springs bear that, wherever the object was seen. The bed's rest depth is to be that of the
/// renderer, to a hundredth of a pixel's width, or a frame throws InvalidInput. One equilibrium a
/// frame, which takes a little memory from the heap.
template <std::floating_point T>
class SpringMembrane {
 public:
  /// `force` in N, towards the gel. SpringBed::press tells what it does with one that cannot be.
  SpringMembrane(SpringBed<T> bed, double force) : bed_(std::move(bed)), force_(force) {}

  /// The memory that `press_into` works in: after a frame, its contact.
  using Workspace = SpringContact<T>;

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const { return whole_image; }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    detail::require_own_size(width, height, bed_.camera().width, bed_.camera().height);
    Workspace work;
    work.indentation = Image<T>(width, height);
    work.touching = Image<std::uint8_t>(width, height);
    return work;
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    require_same_rest(press);
    bed_.press_into(work, press.depth, force_);
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        surface(x, y) = press.rest(x, y) - work.indentation(x, y);
      }
    }
  }
  /// Throws InvalidInput for a camera of another size.
  void require_fits(const Camera<T>& camera) const {
    detail::require_own_size(camera.width, camera.height, bed_.camera().width,
                             bed_.camera().height);
  }
  ///@}

 private:
  void require_same_rest(const Press<T>& press) const {
    const double own{bed_.rest_depth()};
    const double most = 0.01 * own / double{std::max(bed_.camera().fx, bed_.camera().fy)};
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const T seen = press.rest(x, y);
        detail::require(!(std::abs(double{seen} - own) > most), "at pixel (", x, ", ", y,
                        ") the renderer's rest depth is ", seen, " m, the springs' ", own, " m");
      }
    }
  }

  SpringBed<T> bed_;
  double force_;
};

}  // namespace gelight
