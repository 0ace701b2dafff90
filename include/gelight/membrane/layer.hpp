#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "gelight/concepts/image.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/membrane/fourier.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/views/image_view.hpp"

// Opt-in: includes Eigen's unsupported FFT, but where GELIGHT_COMPILED is defined.

namespace gelight {
namespace detail {
class PressedLayer;
struct RigidObject;
struct LayerState;
struct Effort;
}  // namespace detail

/// How an elastic layer is pressed.
struct LayerOptions {
  /// How far the surface may be from the object where they touch, and in it elsewhere, as a share
  /// of the deepest press; of a force, how much may be missing.
  double tolerance = 1e-3;
  /// Of conjugate gradients, for each contact that is looked for. A force is given up when eight of
  /// them have not converged.
  int most_iterations = 500;
  bool sideways = true;              ///< whether to find the displacement along x and y
  CancelHook cancelled = {};         ///< asked once a convolution
  FourierBackend fourier = nullptr;  ///< null: Eigen's; fftw_backend of membrane/fftw.hpp
};

/// How an object is pressed into a layer.
struct LayerLoad {
  /// In N, positive, towards the camera, what the object is to be pressed with; without it the
  /// object stays where the depth image shows it.
  std::optional<double> force = {};
  /// With a force: where the line along which it acts, parallel to the camera's axis, meets the
  /// gel, x and y in m; in the convex hull of the object's pixels, or it would tip over. The object
  /// then tilts until the gel's moment about that line is none; without it it does not tilt.
  std::optional<Vec2<double>> centre = {};
  /// How far the object has moved sideways since it was pressed in, in m; the depth image shows it
  /// where it is then. Without friction (`Gel`'s default) that makes no difference, nor does
  /// `twist`.
  Vec2<double> shift = Vec2<double>(0, 0);
  /// How far it has turned about the camera's axis, in radians from x to y; small: it is taken as
  /// one step along straight lines.
  double twist = 0;
};

/// A rigid object in an elastic layer. Images are of the camera's size; x, y and z are the
/// camera's.
template <std::floating_point T>
struct LayerContact {
  Image<T> indentation;         ///< of the surface, m; negative where it bulges
  Image<T> depth;               ///< of the surface, m: what a renderer is to be given
  Image<T> pressure;            ///< of the object on the gel, Pa
  Image<Vec2<T>> traction;      ///< sideways, of the object on the gel, Pa; empty: none
  Image<Vec3<T>> displacement;  ///< of the surface, m; empty where options leave it out
  /// How far the object is from where it was seen, towards the camera, m.
  double travel = 0;
  /// How much more with every metre along x and y from the camera's axis.
  Vec2<double> tilt = Vec2<double>(0, 0);
  Vec3<double> force = Vec3<double>(0, 0, 0);  ///< of the object on the gel, N; z is negative
  /// The same forces' moments about the point of the gel on the camera's axis, N m.
  Vec3<double> moment = Vec3<double>(0, 0, 0);
  /// The largest angle, in radians, between the gel at rest where it is touched and its mean there:
  /// 0 where it is flat, the contact's radius over its own on a ball.
  double bend = 0;
  bool is_bent_too_far = false;  ///< whether that is beyond ElasticLayer's `most_bend`
  bool converged = true;         ///< whether the rest is as exact as the options ask for
  /// The farthest that the surface is from the object where they touch, in the object elsewhere,
  /// as a share of the deepest press; or from where friction would bring it, as a share of how far
  /// the object has moved sideways, or where it is less of how far it moves the gel where all
  /// slips.
  double residual = 0;
  int iterations = 0;    ///< of conjugate gradients
  int convolutions = 0;  ///< products with a Green's function, the dearest part
  Index unknown = 0;     ///< pixels without a known depth: nothing touches there, images hold NaN
};

/// The gel of a sensor as a linearly elastic layer on a rigid base, and how a rigid object presses
/// it: pressure, force, and displacement in three components.
///
/// The layer is homogeneous, flat and without end; `rest_depth` may be bent a little, the object's
/// depth in it is measured along z. A pixel is taken as mean rest depth / focal length wide
/// everywhere. Small strains: displacements are those of material points, the contact is laid over
/// the surface at rest. Contact is unilateral (nothing holds the object), and frictionless while
/// the object is pressed in; a sideways motion then is held by Coulomb's friction, taken as one
/// step. What lies outside of the image touches nothing. Works in double whatever T is.
///
/// A curved gel is best given as its tangent plane's: depth along its normal, places by arc length.
/// On a ball of 11.5 mm, against the exact solution, the surface is then within 4 % of the press
/// and the force 6 to 34 % too large, for contacts of 1.3 to 5 mm in radius on gels 2 and 4 mm
/// thick; least for small contacts and thin gels. A contact whose rest is bent farther says so.
///
/// Against Hertz, at a contact radius of 40 pixels and the default tolerance: radius 1 %, largest
/// pressure 0.1 %, force 0.05 % off, for 19 convolutions, each two Fourier transforms of twice the
/// object's box; at a tolerance of 1e-5, 0.3 %, 0.003 % and 0.004 % for 57, which is what the
/// pixels leave: of first, second and second order in their size. With friction 54 to 225, the
/// more of them the more sticks and the more the layer couples pressure and traction
/// (benchmarks/layer_benchmark.cpp prints them). Where infinite friction meets a layer that couples
/// the two, pixels at the rim may come and go: then `converged` says no. A copy shares the layer's
/// Green's functions, which are made when first used. May be used by several threads at once, if
/// the options' hook may.
template <std::floating_point T>
class ElasticLayer {
 public:
  /// How far the gel at rest may be bent where it is touched, in radians: 5 mm on a ball of 11.5
  /// mm.
  static constexpr double most_bend = 5 / 11.5;

  /// `rest_depth` is what the camera sees of the untouched gel, in m; NaN, infinity, zero or
  /// negative: no gel is known there, and nothing touches. Throws InvalidInput for a camera that is
  /// not valid, an image of another size, or without a known depth; for an elastic modulus that is
  /// not positive and finite, a thickness that is not positive or below a tenth of a pixel, a
  /// Poisson ratio outside of [0, 0.5], a negative friction or tension; and a tolerance outside of
  /// (0, 1) or number of iterations that is not positive.
  template <ImageOf<T> R>
  ElasticLayer(const Camera<T>& camera, const R& rest_depth, const Gel& gel = {},
               const LayerOptions& options = {})
      : camera_(camera),
        rest_(seen(camera, rest_depth)),
        gel_(gel),
        options_(options),
        mean_rest_(mean(rest_)),
        layer_(made()) {}

  /// The same for a gel that is flat, across the camera's axis.
  ElasticLayer(const Camera<T>& camera, std::type_identity_t<T> rest_depth, const Gel& gel = {},
               const LayerOptions& options = {})
      : ElasticLayer(camera, flat(camera, rest_depth), gel, options) {}

  /// What the layer was made of.
  ///@{
  [[nodiscard]] const Camera<T>& camera() const { return camera_; }
  [[nodiscard]] const Image<T>& rest_depth() const { return rest_; }
  [[nodiscard]] const Gel& gel() const { return gel_; }
  ///@}

  /// A pixel's width and height on the gel, m.
  [[nodiscard]] Vec2<double> pixel() const {
    return {mean_rest_ / double{camera_.fx}, mean_rest_ / double{camera_.fy}};
  }

  /// The contact with an object, given as the depth that the camera would see of it: +infinity
  /// where nothing is, NaN, zero or negative where it is not known.
  ///
  /// With a force the object moves along z until the layer bears it, by a secant search, and tilts
  /// where the load says so, which takes some ten contacts more. All that the image shows is one
  /// object. Starts from the contact `previous`, if there is one, which saves what the two have in
  /// common, but next to nothing with friction, which is sought once the force without it is found;
  /// `convolutions` tells what it took. Throws InvalidInput for a depth image
  /// of another size than the camera's, a force that is negative, not finite or more than the
  /// object can bring (there is none, or it would come through the layer or behind the camera) or
  /// whose centre lies beside the object, a sideways motion that is not finite, and an object that
  /// comes further into the gel than that is thick; Cancelled where the options' hook says so.
  template <ImageOf<T> D>
  [[nodiscard]] LayerContact<T> press(const D& depth, const LayerLoad& load = {},
                                      const LayerContact<T>* previous = nullptr) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    return pressed(read(depth), load, previous);
  }

 private:
  static constexpr T unknown = std::numeric_limits<T>::quiet_NaN();

  static Image<T> flat(const Camera<T>& camera, T rest_depth);

  template <class R>
  static Image<T> seen(const Camera<T>& camera, const R& rest_depth) {
    camera.require_valid();
    detail::require_camera_size(rest_depth, camera, "the rest depth");
    return read(rest_depth);
  }

  template <class D>
  static Image<T> read(const D& depth) {
    Image<T> image(ImageTraits<D>::width(depth), ImageTraits<D>::height(depth));
    for (Index y = 0; y < image.height(); ++y) {
      for (Index x = 0; x < image.width(); ++x) {
        image(x, y) = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      }
    }
    return image;
  }

  [[nodiscard]] LayerContact<T> pressed(const Image<T>& depth, const LayerLoad& load,
                                        const LayerContact<T>* previous) const;

  // What the layer is made into, by what it is made of, which is checked.
  [[nodiscard]] std::shared_ptr<const detail::PressedLayer> made() const;
  void require_valid() const;

  static bool is_known(T depth) { return depth > 0 && std::isfinite(depth); }
  static double mean(const Image<T>& depth);

  // A sideways motion whose square is a number, in m and in pixels.
  static constexpr double farthest = 1e100;

  // What the object is to the layer, in pixels' widths, and how many pixels' depth is not known.
  [[nodiscard]] std::pair<detail::RigidObject, Index> see(const Image<T>& depth,
                                                          const LayerLoad& load) const;
  // The loads of a contact, in shear moduli, to start from.
  [[nodiscard]] detail::LayerState state_of(const LayerContact<T>* contact) const;
  [[nodiscard]] detail::LayerState balance(const detail::RigidObject& object, const LayerLoad& load,
                                           const detail::LayerState& start,
                                           detail::Effort& effort) const;
  void require_under(const detail::RigidObject& object, const Vec2<double>& centre) const;
  [[nodiscard]] LayerContact<T> report(const detail::LayerState& state, Index unknown_pixels,
                                       detail::Effort& effort) const;
  // The normal of the gel at rest at a pixel, of any length; none where that is not known.
  [[nodiscard]] std::optional<Vec3<double>> normal(Index x, Index y) const;
  [[nodiscard]] double bend(const Image<T>& pressure) const;
  // Nothing is known of the surface where the object is not known.
  void clear_unknown(LayerContact<T>& contact, const Image<T>& depth) const;

  Camera<T> camera_;
  Image<T> rest_;
  Gel gel_;
  LayerOptions options_;
  double mean_rest_;
  std::shared_ptr<const detail::PressedLayer> layer_;
};

template <std::floating_point T, class R, class... Others>
ElasticLayer(const Camera<T>&, const R&, const Others&...) -> ElasticLayer<T>;

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/membrane/layer/body.hpp"
#endif
