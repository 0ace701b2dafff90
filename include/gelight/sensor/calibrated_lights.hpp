#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gelight/concepts/reflectance.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/shading/fitted.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// Lights that were fitted on flat gel, on a membrane of any shape: their colours, softness and
/// highlights stay, their directions are those of any light field (linear, geodesic, through gel,
/// traced) in place of the straight lines from their places, and slopes are told from the membrane
/// at rest. A reflectance for TactileRenderer; what is at rest shows the background.
template <std::floating_point T>
class CalibratedLights {
 public:
  /// The renderer tells which pixels an object touches.
  static constexpr bool reads_touched = true;

  /// `rest_normals` are the membrane's, as sobel_normals makes them of its rest depth; zero where
  /// there is none, which stays as the background is. `directions` has an image for each light: the
  /// direction in which it travels when it arrives, as in Light, of the length of its intensity; a
  /// light that has gone a distance of d half images has d to the power of -falloff. Throws
  /// InvalidInput for a bad camera, other than an image a light, images that are not of the
  /// camera's size, numbers that are not finite, normals of another length than 1 or 0, and a model
  /// that write_sensor refuses.
  CalibratedLights(const LightsReflectance& model, Image<Rgb8> background, const Camera<T>& camera,
                   Image<Vec3<T>> rest_normals, std::vector<Image<Vec3<T>>> directions)
      : shared_(
            std::make_shared<const Data>(Data{model, std::move(background), camera,
                                              std::move(rest_normals), std::move(directions)})) {
    const Data& all = *shared_;
    camera.require_valid();
    detail::require_reflectance(model);
    detail::require(all.directions.size() == model.lights.size(), all.directions.size(),
                    " images of directions for ", model.lights.size(), " lights");
    require_size(all.background, camera, "the background");
    require_size(all.rest_normals, camera, "the image of normals at rest");
    require_all(all.rest_normals, "the normal at rest", "finite, and of length 1 or 0", is_normal);
    for (std::size_t k = 0; k < all.directions.size(); ++k) {
      require_size(all.directions[k], camera, "an image of directions");
      require_all(all.directions[k], detail::joined("the direction of light ", k), "finite",
                  [](const Vec3<T>& v) { return detail::is_finite(v); });
    }
  }

  /// Throws InvalidInput for a camera of another size.
  void require_fits(const Camera<T>& camera) const {
    require_size(shared_->background, camera, "the background");
  }

  /// As concepts/reflectance.hpp says.
  void shade_row(const ColourRow<T>& out, const SurfaceRow<T>& row) const {
    constexpr double half_level = 0.5 / 255;
    for (std::ptrdiff_t i = 0; i < row.count; ++i) {
      const Index x = row.x + static_cast<Index>(i);
      const Vec3<double> n(row.nx[i], row.ny[i], row.nz[i]);
      const bool touched = row.touched != nullptr && row.touched[i] != 0;
      const Change by = change_at(x, row.y, n, touched);
      const Rgb8& rest = shared_->background(x, row.y);
      std::array<T*, 3> to{out.r, out.g, out.b};
      for (std::size_t c = 0; c < 3; ++c) {
        to[c][i] = static_cast<T>(rest[c] / 255.0 * (1 + by[c]) + half_level);
      }
    }
  }

 private:
  struct Data {
    LightsReflectance model;
    Image<Rgb8> background;
    Camera<T> camera;
    Image<Vec3<T>> rest_normals;
    std::vector<Image<Vec3<T>>> directions;
  };

  template <class I>
  static void require_size(const I& image, const Camera<T>& camera, const char* what) {
    detail::require(image.width() == camera.width && image.height() == camera.height, what, " has ",
                    image.width(), " x ", image.height(), " pixels, the camera ", camera.width,
                    " x ", camera.height);
  }
  [[nodiscard]] static bool is_normal(const Vec3<T>& n) {
    return n.isZero(0) || std::abs(norm(cast<double>(n)) - 1) < 1e-3;
  }
  template <class Is>
  static void require_all(const Image<Vec3<T>>& image, const std::string& what, const char* how,
                          const Is& is) {
    for (Index y = 0; y < image.height(); ++y) {
      for (Index x = 0; x < image.width(); ++x) {
        const Vec3<T>& v = image(x, y);
        detail::require(is(v), what, " at pixel (", x, ", ", y, ") is (", v.x(), ", ", v.y(), ", ",
                        v.z(), "), not ", how);
      }
    }
  }

  [[nodiscard]] Change change_at(Index x, Index y, const Vec3<double>& n, bool touched) const {
    const Data& all = *shared_;
    const Vec3<double> rest = cast<double>(all.rest_normals(x, y));
    if (n.isZero() || rest.isZero()) return {};
    const Vec3<double> to_eye =
        -normalized(cast<double>(all.camera.ray(static_cast<T>(x), static_cast<T>(y))));
    Change sum{};
    for (std::size_t c = 0; c < 3; ++c) sum[c] = all.model.ambient[c] * (1 - dot(n, rest));
    for (std::size_t k = 0; k < all.directions.size(); ++k) {
      const Vec3<double> way = -cast<double>(all.directions[k](x, y));
      const double strength = norm(way);
      if (strength == 0) continue;
      const auto terms = detail::terms_of(all.model, strength, way / strength, n, rest, to_eye);
      const NearLight& light = all.model.lights[k];
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += light.diffuse[c] * terms.diffuse + light.specular[c] * terms.specular;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] = touched ? sum[c] + all.model.contact[c] : sum[c] * all.model.free_share[c];
    }
    return sum;
  }

  std::shared_ptr<const Data> shared_;  // copies of a reflectance read the same images
};

}  // namespace gelight
