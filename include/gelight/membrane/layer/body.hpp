#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/layer/contact.hpp"
#include "gelight/membrane/layer/convolution.hpp"
#include "gelight/membrane/layer/eigen_fourier.hpp"
#include "gelight/membrane/layer/green.hpp"
#include "gelight/membrane/layer/pressed_layer.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

template <std::floating_point T>
LayerContact<T> ElasticLayer<T>::pressed(const Image<T>& depth, const LayerLoad& load,
                                         const LayerContact<T>* previous) const {
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
  const detail::LayerState state =
      load.force ? balance(object, load, start, effort) : layer_->settle(object, 0, start, effort);
  LayerContact<T> contact = report(state, unknown_pixels, effort);
  // First: where there is no gel, zero and negative depths stand for that.
  if (unknown_pixels > 0) clear_unknown(contact, depth);
  for (const T z : contact.depth.pixels()) {
    detail::require(!(z <= 0), "a force of ", load.force.value_or(0),
                    " N would bring the gel's surface behind the camera");
  }
  return contact;
}

template <std::floating_point T>
Image<T> ElasticLayer<T>::flat(const Camera<T>& camera, T rest_depth) {
  camera.require_valid();
  detail::require(rest_depth > 0 && std::isfinite(rest_depth), "rest depth ", rest_depth,
                  " is not positive and finite");
  return Image<T>(camera.width, camera.height, rest_depth);
}

template <std::floating_point T>
std::shared_ptr<const detail::PressedLayer> ElasticLayer<T>::made() const {
  require_valid();
  const detail::LayerGrid grid{camera_.width, camera_.height, pixel().y() / pixel().x(),
                               gel_.thickness / pixel().x(), gel_.poisson_ratio};
  return std::make_shared<const detail::PressedLayer>(
      grid, gel_.friction, options_.fourier != nullptr ? options_.fourier : detail::eigen_backend);
}

template <std::floating_point T>
double ElasticLayer<T>::mean(const Image<T>& depth) {
  double sum = 0;
  std::size_t known = 0;
  for (const T z : depth.pixels()) {
    sum += is_known(z) ? double{z} : 0;
    known += is_known(z) ? 1 : 0;
  }
  detail::require(known > 0, "the rest depth is known nowhere");
  return sum / static_cast<double>(known);
}

template <std::floating_point T>
void ElasticLayer<T>::require_valid() const {
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

// What the object is to the layer, in pixels' widths, and how many pixels' depth is not known.
template <std::floating_point T>
std::pair<detail::RigidObject, Index> ElasticLayer<T>::see(const Image<T>& depth,
                                                           const LayerLoad& load) const {
  using namespace detail::arithmetic;
  detail::RigidObject object;
  object.shift = load.shift / pixel().x();
  object.twist = load.twist;
  object.axis = {double{camera_.cx}, double{camera_.cy}};
  Index unknown_pixels = 0;
  for (Index y = 0; y < camera_.height; ++y) {
    for (Index x = 0; x < camera_.width; ++x) {
      const T z = depth(x, y), rest = rest_(x, y);
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
template <std::floating_point T>
detail::LayerState ElasticLayer<T>::state_of(const LayerContact<T>* contact) const {
  detail::LayerState state;
  if (contact == nullptr) return state;
  detail::require_camera_size(contact->pressure, camera_, "the previous contact's pressure");
  detail::require(std::isfinite(contact->travel), "the previous contact's travel ", contact->travel,
                  " is not finite");
  state.box = {0, 0, camera_.width, camera_.height};
  state.travel = contact->travel / pixel().x();
  for (const T p : contact->pressure.pixels()) {
    detail::require(!std::isinf(p), "the previous contact's pressure is infinite at a pixel");
    state.pressure.push_back(p > 0 ? double{p} / gel_.shear_modulus() : 0);
  }
  if (contact->traction.pixels().size() != contact->pressure.pixels().size()) return state;
  for (const int k : {0, 1}) {
    for (const Vec2<T>& q : contact->traction.pixels()) {
      detail::require(!std::isinf(q[k]), "the previous contact's traction is infinite at a pixel");
      state.traction.push_back(std::isfinite(q[k]) ? double{q[k]} / gel_.shear_modulus() : 0);
    }
  }
  return state;
}

template <std::floating_point T>
detail::LayerState ElasticLayer<T>::balance(const detail::RigidObject& object,
                                            const LayerLoad& load, const detail::LayerState& start,
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
template <std::floating_point T>
void ElasticLayer<T>::require_under(const detail::RigidObject& object,
                                    const Vec2<double>& centre) const {
  detail::Array<detail::SpringRow> rows(static_cast<std::size_t>(camera_.height));
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

template <std::floating_point T>
LayerContact<T> ElasticLayer<T>::report(const detail::LayerState& state, Index unknown_pixels,
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
template <std::floating_point T>
std::optional<Vec3<double>> ElasticLayer<T>::normal(Index x, Index y) const {
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

template <std::floating_point T>
double ElasticLayer<T>::bend(const Image<T>& pressure) const {
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
template <std::floating_point T>
void ElasticLayer<T>::clear_unknown(LayerContact<T>& contact, const Image<T>& depth) const {
  for (Index y = 0; y < camera_.height; ++y) {
    for (Index x = 0; x < camera_.width; ++x) {
      if (depth(x, y) > 0 && is_known(rest_(x, y))) continue;
      contact.indentation(x, y) = contact.depth(x, y) = contact.pressure(x, y) = unknown;
      if (!contact.traction.pixels().empty()) contact.traction(x, y).fill(unknown);
      if (options_.sideways) contact.displacement(x, y).fill(unknown);
    }
  }
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class ElasticLayer<float>;
template class ElasticLayer<double>;
}  // namespace gelight
#endif
