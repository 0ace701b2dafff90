#pragma once

#include <concepts>
#include <utility>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/types.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A bed of springs as a renderer's membrane: whatever touches it is pressed in by a force until
/// the springs bear that, wherever the object was seen. The bed's rest depth is to be that of the
/// renderer. One equilibrium a frame, which takes a little memory from the heap.
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
    Workspace work;
    work.indentation = Image<T>(width, height);
    work.touching = Image<std::uint8_t>(width, height);
    return work;
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    bed_.press_into(work, press.depth, force_);
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        surface(x, y) = press.rest(x, y) - work.indentation(x, y);
      }
    }
  }
  ///@}

 private:
  SpringBed<T> bed_;
  double force_;
};

}  // namespace gelight
