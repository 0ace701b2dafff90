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
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/smoothing.hpp"
#include "gelight/views/image_view.hpp"

// What an object hides of a membrane's bulge, after the GelTip authors' later code.
namespace gelight {

/// How a contact's shadow is cast.
struct ContactShadow {
  double contact = 1e-5;  ///< how far an object is pressed in to count, in the unit of the depth
  double sigma = 5;       ///< how soft the shadow is, in pixels
  Index radius = 27;      ///< where the softening is cut off, in pixels
  Index gap = 3;          ///< how far around the object there is none, in pixels
};

/// A GaussianMembrane whose bulge is the lower where the object hides it from the camera: in soft
/// bands along the edges of the contact where it falls off the way that the ray runs. The bands are
/// scaled to the darkest of them, so that they depend on the whole image; where softening leaves no
/// more of them than rounding, there are none.
template <std::floating_point T>
class ShadowedMembrane {
 public:
  /// Throws InvalidInput for a camera that is not valid, a contact that is not finite or a negative
  /// gap, and as gaussian_weights does.
  ShadowedMembrane(const Camera<T>& camera, GaussianMembrane<T> bulge,
                   const ContactShadow& shadow = {})
      : camera_(camera),
        bulge_(std::move(bulge)),
        shadow_(shadow),
        weights_(gaussian_weights<double>(shadow.sigma, shadow.radius)) {
    camera.require_valid();
    detail::require(shadow.gap >= 0, "gap ", shadow.gap, " is negative");
    detail::require(std::isfinite(shadow.contact), "contact ", shadow.contact, " is not finite");
  }

  /// The memory that `press_into` works in.
  struct Workspace {
    typename GaussianMembrane<T>::Workspace bulge;  ///< of the bulge
    detail::Smoother<double> smoother;              ///< of the shadow
    Image<double> touching;                         ///< 1 where the object touches
    Image<double> hidden;                           ///< 1 where the contact falls off
    Image<double> rows;                             ///< marks grown along the rows
    Image<double> soft;                             ///< the same as `hidden`, softened
    Image<T> shadow;                                ///< how much of the bulge is hidden, 0 to 1
  };

  /// How much of the bulge is hidden at each pixel, from 0 to 1; 0 on the contact, and everywhere
  /// where nothing touches. Stays in the workspace.
  const Image<T>& shadow_into(Workspace& work, const Press<T>& press) const {
    const Index width = camera_.width, height = camera_.height;
    const Window whole{0, 0, width, height};
    const T least = static_cast<T>(shadow_.contact);
    for_each_pixel([&](Index x, Index y) {
      const T pressed = detail::protrusion(press.depth(x, y), press.rest(x, y));
      work.touching(x, y) = pressed > least ? 1 : 0;
    });
    mark_hidden(work);
    dilate(work.hidden, work.rows, 1);
    // In double, for it is stretched: on small images it is all but the same everywhere.
    work.smoother.mean_into(work.soft, work.hidden, whole, weights_);
    const auto& [low, high] =
        std::minmax_element(work.soft.pixels().begin(), work.soft.pixels().end());
    const double dimmest = *low, range = *high - *low;
    const bool is_anywhere = range > rounding * *high;
    dilate(work.touching, work.rows, shadow_.gap);
    for_each_pixel([&](Index x, Index y) {
      const bool is_beside = is_anywhere && work.touching(x, y) == 0;
      work.shadow(x, y) = is_beside ? static_cast<T>((work.soft(x, y) - dimmest) / range) : 0;
    });
    return work.shadow;
  }

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const { return whole_image; }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    detail::require_own_size(width, height, camera_.width, camera_.height);
    const Image<double> image(width, height);
    return {bulge_.make_workspace(width, height),
            detail::Smoother<double>(width, height, shadow_.radius),
            image,
            image,
            image,
            image,
            Image<T>(width, height)};
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    bulge_.press_into(surface, press, work.bulge);
    const Image<T>& shadow = shadow_into(work, press);
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const T rest = press.rest(x, y);
        surface(x, y) = rest - (1 - shadow(x, y)) * (rest - surface(x, y));
      }
    }
  }
  /// As the bulge's.
  [[nodiscard]] bool clips_to_rest() const { return bulge_.clips_to_rest(); }
  /// Throws InvalidInput for a camera of another size.
  void require_fits(const Camera<T>& camera) const {
    detail::require_own_size(camera.width, camera.height, camera_.width, camera_.height);
  }
  ///@}

 private:
  // The share of the softened marks that they must differ by, lest rounding is stretched.
  static constexpr double rounding = 1000 * std::numeric_limits<double>::epsilon();

  template <class Work>
  void for_each_pixel(const Work& work) const {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) work(x, y);
    }
  }

  // Where the contact grows along the ray, by its Sobel derivatives.
  void mark_hidden(Workspace& work) const {
    const Index width = camera_.width, height = camera_.height;
    for_each_pixel([&](Index x, Index y) {
      const auto at = [&](Index dx, Index dy) {
        return work.touching(detail::inside(x + dx, width, Border::reflect101),
                             detail::inside(y + dy, height, Border::reflect101));
      };
      const double across =
          (at(1, -1) - at(-1, -1)) + 2 * (at(1, 0) - at(-1, 0)) + (at(1, 1) - at(-1, 1));
      const double down =
          (at(-1, 1) - at(-1, -1)) + 2 * (at(0, 1) - at(0, -1)) + (at(1, 1) - at(1, -1));
      const Vec3<T> ray = camera_.ray(static_cast<T>(x), static_cast<T>(y));
      work.hidden(x, y) = across * double{ray.x()} > 0 || down * double{ray.y()} > 0 ? 1 : 0;
    });
  }

  // Marks all pixels of the (2 reach + 1)^2 around each mark.
  void dilate(Image<double>& marks, Image<double>& rows, Index reach) const {
    const Index width = camera_.width, height = camera_.height;
    const Index radius = std::min(reach, std::max(width, height));  // a larger one might overflow
    for_each_pixel([&](Index x, Index y) {
      const double* const row = marks.row(y);
      rows(x, y) = *std::max_element(row + std::max(Index{0}, x - radius),
                                     row + std::min(width, x + radius + 1));
    });
    for (Index y = 0; y < height; ++y) {
      std::fill_n(marks.row(y), width, 0.0);
      for (Index j = std::max(Index{0}, y - radius); j < std::min(height, y + radius + 1); ++j) {
        for (Index x = 0; x < width; ++x) marks(x, y) = std::max(marks(x, y), rows(x, j));
      }
    }
  }

  Camera<T> camera_;
  GaussianMembrane<T> bulge_;
  ContactShadow shadow_;
  std::vector<double> weights_;
};

}  // namespace gelight
