#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/membrane/fourier.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/membrane/layer/contact.hpp"
#include "gelight/membrane/layer/eigen_fourier.hpp"
#include "gelight/membrane/layer/green.hpp"
#include "gelight/membrane/layer/pressed_layer.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/views/image_view.hpp"

// Opt-in: includes Eigen's unsupported FFT.

namespace gelight {

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
        layer_(std::make_shared<const detail::PressedLayer>(
            grid(), gel.friction,
            options.fourier != nullptr ? options.fourier : detail::eigen_backend)) {}

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
  /// where the load says so, which takes some ten contacts more. Starts
  /// from the contact `previous`, if there is one, which saves what the two have in common, but
  /// next to nothing with friction. Throws InvalidInput for a depth image of another size than the
  /// camera's, a force that is negative, not finite or more than the object can bring (there is
  /// none, or it would come through the layer or behind the camera) or whose centre lies beside the
  /// object, a sideways motion that is not finite, and an object that comes further into the gel
  /// than that is thick; Cancelled where the options' hook says so.
  template <ImageOf<T> D>
  [[nodiscard]] LayerContact<T> press(const D& depth, const LayerLoad& load = {},
                                      const LayerContact<T>* previous = nullptr) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    detail::require(!load.force || (*load.force >= 0 && std::isfinite(*load.force)), "force ",
                    load.force.value_or(0), " is negative or not finite");
    detail::require(!load.centre || load.force, "a force's centre is given, but there is no force");
    detail::require(!load.centre || load.centre->allFinite(), "the force's centre (",
                    load.centre.value_or(Vec2<double>(0, 0)).x(), ", ",
                    load.centre.value_or(Vec2<double>(0, 0)).y(), ") is not finite");
    detail::require(std::abs(load.shift.x()) <= farthest && std::abs(load.shift.y()) <= farthest &&
                        std::abs(load.twist) <= farthest,
                    "the sideways motion (", load.shift.x(), ", ", load.shift.y(), ") turning by ",
                    load.twist, " is not finite or beyond ", farthest);
    const auto [object, unknown_pixels] = see(depth, load);
    detail::Effort effort{options_.cancelled, options_.tolerance, options_.most_iterations};
    detail::require(load.force || object.deepest * pixel().x() < gel_.thickness, "at pixel (",
                    object.x, ", ", object.y, ") the object stands ", object.deepest * pixel().x(),
                    " m in the gel, which is ", gel_.thickness, " m thick");
    const detail::LayerState start = state_of(previous);
    const detail::LayerState state = load.force ? balance(object, load, start, effort)
                                                : layer_->settle(object, 0, start, effort);
    LayerContact<T> contact = report(state, unknown_pixels, effort);
    // First: where there is no gel, zero and negative depths stand for that.
    if (unknown_pixels > 0) clear_unknown(contact, depth);
    for (const T z : contact.depth.pixels()) {
      detail::require(!(z <= 0), "a force of ", load.force.value_or(0),
                      " N would bring the gel's surface behind the camera");
    }
    return contact;
  }

 private:
  static constexpr T unknown = std::numeric_limits<T>::quiet_NaN();

  static Image<T> flat(const Camera<T>& camera, T rest_depth) {
    camera.require_valid();
    detail::require(rest_depth > 0 && std::isfinite(rest_depth), "rest depth ", rest_depth,
                    " is not positive and finite");
    return Image<T>(camera.width, camera.height, rest_depth);
  }

  template <class R>
  static Image<T> seen(const Camera<T>& camera, const R& rest_depth) {
    camera.require_valid();
    detail::require_camera_size(rest_depth, camera, "the rest depth");
    Image<T> image(camera.width, camera.height);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        image(x, y) = static_cast<T>(ImageTraits<R>::pixel(rest_depth, x, y));
      }
    }
    return image;
  }

  // Checks what the layer is made of on the way.
  [[nodiscard]] detail::LayerGrid grid() const {
    require_valid();
    return {camera_.width, camera_.height, pixel().y() / pixel().x(), gel_.thickness / pixel().x(),
            gel_.poisson_ratio};
  }

  static bool is_known(T depth) { return depth > 0 && std::isfinite(depth); }

  static double mean(const Image<T>& depth) {
    double sum = 0;
    std::size_t known = 0;
    for (const T z : depth.pixels()) {
      sum += is_known(z) ? double{z} : 0;
      known += is_known(z) ? 1 : 0;
    }
    detail::require(known > 0, "the rest depth is known nowhere");
    return sum / static_cast<double>(known);
  }

  void require_valid() const {
    detail::require(gel_.elastic_modulus > 0 && std::isfinite(gel_.elastic_modulus),
                    "elastic modulus ", gel_.elastic_modulus, " is not positive and finite");
    detail::require(gel_.poisson_ratio >= 0 && gel_.poisson_ratio <= 0.5, "Poisson ratio ",
                    gel_.poisson_ratio, " is not between 0 and 0.5");
    detail::require(gel_.thickness >= 0.1 * pixel().maxCoeff(), "gel thickness ", gel_.thickness,
                    " is not positive, or below a tenth of a pixel, which is ", pixel().maxCoeff(),
                    " wide");
    detail::require(gel_.friction >= 0, "friction ", gel_.friction, " is negative or NaN");
    detail::require(gel_.tension >= 0 && std::isfinite(gel_.tension), "tension ", gel_.tension,
                    " is negative or not finite");
    detail::require(options_.tolerance > 0 && options_.tolerance < 1, "tolerance ",
                    options_.tolerance, " is not between 0 and 1");
    detail::require(options_.most_iterations > 0, "number of iterations ", options_.most_iterations,
                    " is not positive");
  }

  // A sideways motion whose square is a number, in m and in pixels.
  static constexpr double farthest = 1e100;

  // What the object is to the layer, in pixels' widths, and how many pixels' depth is not known.
  template <class D>
  [[nodiscard]] std::pair<detail::RigidObject, Index> see(const D& depth,
                                                          const LayerLoad& load) const {
    using namespace detail::arithmetic;
    detail::RigidObject object;
    object.shift = load.shift / pixel().x();
    object.twist = load.twist;
    object.axis = {double{camera_.cx}, double{camera_.cy}};
    Index unknown_pixels = 0;
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        const T z = static_cast<T>(ImageTraits<D>::pixel(depth, x, y)), rest = rest_(x, y);
        object.overlap.push_back(detail::RigidObject::nothing);
        if (!(z > 0) || !is_known(rest)) ++unknown_pixels;
        if (!is_known(z) || !is_known(rest)) continue;
        const double overlap = (double{rest} - double{z}) / pixel().x();
        object.overlap.back() = overlap;
        if (!(overlap > object.deepest)) continue;
        object.deepest = overlap;
        object.x = x;
        object.y = y;
      }
    }
    return {std::move(object), unknown_pixels};
  }

  // The loads of a contact, in shear moduli, to start from.
  [[nodiscard]] detail::LayerState state_of(const LayerContact<T>* contact) const {
    detail::LayerState state;
    if (contact == nullptr) return state;
    detail::require_camera_size(contact->pressure, camera_, "the previous contact's pressure");
    detail::require(std::isfinite(contact->travel), "the previous contact's travel ",
                    contact->travel, " is not finite");
    state.box = {0, 0, camera_.width, camera_.height};
    state.travel = contact->travel / pixel().x();
    for (const T p : contact->pressure.pixels()) {
      detail::require(!std::isinf(p), "the previous contact's pressure is infinite at a pixel");
      state.pressure.push_back(p > 0 ? double{p} / gel_.shear_modulus() : 0);
    }
    if (contact->traction.pixels().size() != contact->pressure.pixels().size()) return state;
    for (const int k : {0, 1}) {
      for (const Vec2<T>& q : contact->traction.pixels()) {
        detail::require(!std::isinf(q[k]),
                        "the previous contact's traction is infinite at a pixel");
        state.traction.push_back(std::isfinite(q[k]) ? double{q[k]} / gel_.shear_modulus() : 0);
      }
    }
    return state;
  }

  [[nodiscard]] detail::LayerState balance(const detail::RigidObject& object, const LayerLoad& load,
                                           const detail::LayerState& start,
                                           detail::Effort& effort) const {
    using namespace detail::arithmetic;
    const double force = *load.force;
    if (force == 0) {
      // Where the object begins to touch.
      detail::LayerState state;
      if (std::isfinite(object.deepest)) state.travel = -object.deepest;
      return state;
    }
    detail::require(std::isfinite(object.deepest), "there is no object to bear a force of ", force,
                    " N");
    if (load.centre) require_under(object, *load.centre);
    const double pixels = force / (gel_.shear_modulus() * pixel().prod());
    auto state = load.centre ? layer_->balance_tilting(object, pixels, *load.centre / pixel().x(),
                                                       start, effort)
                             : layer_->balance(object, pixels, start, effort);
    detail::require(state.has_value(), "a force of ", force,
                    " N would bring the object through the gel, which is ", gel_.thickness,
                    " m thick");
    return std::move(*state);
  }

  // However an object tilts, the gel presses on its pixels alone: in their hull lies its force.
  void require_under(const detail::RigidObject& object, const Vec2<double>& centre) const {
    std::vector<detail::SpringRow> rows(static_cast<std::size_t>(camera_.height));
    for (Index y = 0; y < camera_.height; ++y) {
      const double* const line = &object.overlap[std::ptrdiff_t{y} * camera_.width];
      auto& row = rows[static_cast<std::size_t>(y)];
      for (Index x = 0; x < camera_.width; ++x) {
        if (!std::isfinite(line[x])) continue;
        if (row.end == 0) row.begin = x;
        row.end = x + 1;
      }
    }
    const Vec2<double> place = object.axis + centre.cwiseQuotient(pixel());
    detail::require(detail::is_under_object(rows, place.x(), place.y()), "the force's centre (",
                    centre.x(), ", ", centre.y(), "), at pixel (", place.x(), ", ", place.y(),
                    "), lies beside the object, which would tip over");
  }

  [[nodiscard]] LayerContact<T> report(const detail::LayerState& state, Index unknown_pixels,
                                       detail::Effort& effort) const {
    using namespace detail::arithmetic;
    const double scale = pixel().x(), modulus = gel_.shear_modulus();
    const auto surface = layer_->surface(state, options_.sideways, effort);
    LayerContact<T> contact;
    const Image<T> blank(camera_.width, camera_.height);
    contact.indentation = contact.depth = contact.pressure = blank;
    if (!state.traction.empty()) contact.traction = {camera_.width, camera_.height};
    if (options_.sideways) contact.displacement = {camera_.width, camera_.height};
    const std::ptrdiff_t pixels = std::ptrdiff_t{camera_.width} * camera_.height;
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        const std::ptrdiff_t i = std::ptrdiff_t{y} * camera_.width + x;
        const double down = scale * surface[i];
        contact.indentation(x, y) = static_cast<T>(down);
        contact.depth(x, y) = static_cast<T>(double{rest_(x, y)} - down);
        if (!options_.sideways) continue;
        contact.displacement(x, y) = {static_cast<T>(scale * surface[pixels + i]),
                                      static_cast<T>(scale * surface[2 * pixels + i]),
                                      static_cast<T>(-down)};
      }
    }
    const detail::Box& box = state.box;
    const auto area = static_cast<std::ptrdiff_t>(box.area());
    for (Index y = box.top; y < box.top + box.height; ++y) {
      for (Index x = box.left; x < box.left + box.width; ++x) {
        const std::ptrdiff_t i = box.place(x, y);
        Vec3<double> load(0, 0, -modulus * state.pressure[i]);
        if (!state.traction.empty()) {
          load.head<2>() = modulus * Vec2<double>(state.traction[i], state.traction[area + i]);
          contact.traction(x, y) = load.head<2>().cast<T>();
        }
        contact.pressure(x, y) = static_cast<T>(-load.z());
        load *= pixel().prod();
        contact.force += load;
        const Vec3<double> arm((x - double{camera_.cx}) * pixel().x(),
                               (y - double{camera_.cy}) * pixel().y(), 0);
        contact.moment += cross(arm, load);
      }
    }
    contact.bend = bend(contact.pressure);
    contact.is_bent_too_far = contact.bend > most_bend;
    contact.travel = scale * state.travel;
    contact.tilt = state.tilt;
    contact.residual = state.residual;
    contact.converged = state.residual <= options_.tolerance;
    contact.iterations = effort.iterations;
    contact.convolutions = effort.convolutions;
    contact.unknown = unknown_pixels;
    return contact;
  }

  // The normal of the gel at rest at a pixel, of any length; none where that is not known.
  [[nodiscard]] std::optional<Vec3<double>> normal(Index x, Index y) const {
    using namespace detail::arithmetic;
    const auto point = [&](Index u, Index v) -> Vec3<double> {
      u = std::clamp(u, Index{0}, camera_.width - 1);
      v = std::clamp(v, Index{0}, camera_.height - 1);
      const double z = is_known(rest_(u, v)) ? double{rest_(u, v)} : double{unknown};
      return camera_.template cast<double>().unproject(u, v, z);
    };
    const Vec3<double> result =
        cross<double>(point(x + 1, y) - point(x - 1, y), point(x, y + 1) - point(x, y - 1));
    if (!(norm(result) > 0)) return {};
    return result;
  }

  [[nodiscard]] double bend(const Image<T>& pressure) const {
    using namespace detail::arithmetic;
    const auto for_touched = [&](const auto& work) {
      for (Index y = 0; y < camera_.height; ++y) {
        for (Index x = 0; x < camera_.width; ++x) {
          if (!(pressure(x, y) > 0)) continue;
          if (const auto here = normal(x, y)) work(x, y, *here);
        }
      }
    };
    Vec3<double> mean = Vec3<double>(0, 0, 0);
    for_touched([&](Index x, Index y, const Vec3<double>& here) {
      mean += double{pressure(x, y)} / norm(here) * here;
    });
    double most = 0;
    for_touched([&](Index, Index, const Vec3<double>& here) {
      most = std::max(most, std::atan2(norm(cross<double>(mean, here)), dot(mean, here)));
    });
    return most;
  }

  // Nothing is known of the surface where the object is not known.
  template <class D>
  void clear_unknown(LayerContact<T>& contact, const D& depth) const {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        if (static_cast<T>(ImageTraits<D>::pixel(depth, x, y)) > 0 && is_known(rest_(x, y)))
          continue;
        contact.indentation(x, y) = contact.depth(x, y) = contact.pressure(x, y) = unknown;
        if (!contact.traction.pixels().empty()) contact.traction(x, y).fill(unknown);
        if (options_.sideways) contact.displacement(x, y).fill(unknown);
      }
    }
  }

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
