#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/frame/output.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/sensor/rows/shaded_rows.hpp"
#include "gelight/sensor/see_through.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

template <std::floating_point T>
void SeeThroughRenderer<T>::require_valid(const SeeThroughOptions& options) {
  const auto in_range = [](bool valid, const char* name, double value, const char* range) {
    detail::require(valid, name, ' ', value, " is not ", range);
  };
  const auto is_share = [](double value) { return value >= 0 && value <= 1; };
  constexpr double most_light = detail::most_light<T>;
  const double r = options.reflectance, t = options.transmittance;
  in_range(options.thickness > 0, "thickness", options.thickness, "positive");
  in_range(options.normal_radius >= 1, "normal radius", options.normal_radius, "at least 1");
  in_range(std::isfinite(options.ambient), "ambient", options.ambient, "finite");
  detail::require(std::abs(options.ambient) <= most_light, "ambient ", options.ambient,
                  " is more than the images' type can hold");
  in_range(is_share(options.darkening), "darkening", options.darkening, "in [0, 1]");
  in_range(options.darkening_depth > 0, "darkening depth", options.darkening_depth, "positive");
  in_range(static_cast<T>(options.darkening_depth) >= std::numeric_limits<T>::min(),
           "darkening depth", options.darkening_depth, "large enough to divide by");
  in_range(is_share(r), "reflectance", r, "in [0, 1]");
  in_range(is_share(t), "transmittance", t, "in [0, 1]");
  detail::require(r + t <= 1, "reflectance ", r, " and transmittance ", t, " are more than 1");
  in_range(options.exposure > 0 && std::isfinite(options.exposure), "exposure", options.exposure,
           "positive and finite");
  detail::require(options.exposure <= most_light, "exposure ", options.exposure,
                  " is more than the images' type can hold");
  require_level(options.levels.inner, "inner", options);
  require_level(options.levels.outer, "outer", options);
}

template <std::floating_point T>
void SeeThroughRenderer<T>::require_level(double level, const char* side,
                                          const SeeThroughOptions& options) {
  constexpr double most_light = detail::most_light<T>;
  detail::require(level >= 0 && std::isfinite(level), side, " light level ", level,
                  " is negative or not finite");
  detail::require(level <= most_light && level * options.exposure <= most_light, side,
                  " light level ", level, " at exposure ", options.exposure,
                  " is more than the images' type can hold");
}

template <std::floating_point T>
auto SeeThroughRenderer<T>::make_workspace() const -> Workspace {
  const std::vector<T> row(static_cast<std::size_t>(camera_.width));
  return {Image<T>(camera_.width, camera_.height),
          {},
          planes_,
          lights_.make_workspace(),
          {row, row, row, row},
          {row, row, row},
          {row, row, row},
          row,
          std::vector<std::int32_t>(row.size())};
}

template <std::floating_point T>
void SeeThroughRenderer<T>::keep_colour(const Background<T>& background) {
  const T scale = static_cast<T>(255 * options_.exposure * options_.reflectance);
  for (Index y = 0; y < camera_.height; ++y) {
    for (Index x = 0; x < camera_.width; ++x) {
      const auto& rgb = background.is_image() ? background.image()(x, y) : background.solid();
      for (std::size_t c = 0; c < 3; ++c) colour_[offset(y, c) + x] = scale * rgb[c];
    }
  }
}

template <std::floating_point T>
void SeeThroughRenderer<T>::light_rest() {
  Workspace work = make_workspace();
  work.gel = rest_;
  work.changed = {0, 0, camera_.width, camera_.height};
  for (Index y = 0; y < camera_.height; ++y) {
    light_row(work, y);
    for (std::size_t c = 0; c < 3; ++c) {
      std::copy_n(work.lit[c].data(), camera_.width, rest_light_.data() + offset(y, c));
    }
  }
}

template <std::floating_point T>
void SeeThroughRenderer<T>::start_fit(Workspace& work) const {
  work.planes.start(work.changed.left, work.changed.right);
  const Index seen = std::min(camera_.height, work.changed.top + reach());
  for (Index y = first_seen(work.changed); y < work.changed.top + reach(); ++y) {
    work.planes.enter(y < seen ? work.gel.row(y) : nullptr, y);
  }
}

template <std::floating_point T>
void SeeThroughRenderer<T>::light_row(Workspace& work, Index y) const {
  detail::vectorised([&] {
    if (y == work.changed.top) start_fit(work);
    fit_and_light(work, y);
  });
}

template <std::floating_point T>
void SeeThroughRenderer<T>::fit_and_light(Workspace& work, Index y) const {
  const detail::Run run{work.changed.left, work.changed.right};
  const std::ptrdiff_t begin = run.begin, count = run.end - run.begin;
  const detail::DirectionRow<T> n{work.normals[0].data(), work.normals[1].data(),
                                  work.normals[2].data(), work.normals[3].data()};
  const Index below = y + reach();
  work.planes.enter(below < camera_.height ? work.gel.row(below) : nullptr, below);
  work.planes.fit(n, y);
  const T *const gel = work.gel.row(y) + begin, *const rest = rest_.row(y) + begin;
  for (T* const coordinate : {n.x, n.y, n.z, n.facing}) clear_unknown(coordinate, gel, count);
  const auto light = lights_.light(work.lights, y, run, n);
  T* const kept = work.kept.data();
  for (std::ptrdiff_t i = 0; i < count; ++i) kept[i] = rest[i] - gel[i];
  detail::keep_row(kept, static_cast<T>(options_.darkening),
                   static_cast<T>(options_.darkening_depth), count);
  for (std::size_t c = 0; c < 3; ++c) {
    T* const out = work.lit[c].data() + begin;
    detail::multiply_rows(out, light[c], kept, count);
    scale_row(out, colour_.data() + offset(y, c) + begin, count);
  }
}

template <std::floating_point T>
void SeeThroughRenderer<T>::clear_unknown(T* __restrict row, const T* depth, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) row[i] = depth[i] > 0 ? row[i] : 0;
}

template <std::floating_point T>
void SeeThroughRenderer<T>::scale_row(T* __restrict row, const T* scale, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) row[i] *= scale[i];
}

template <std::floating_point T>
void SeeThroughRenderer<T>::write_row(ImageView<Rgb8> out, Workspace& work, Index y,
                                      T inner) const {
  const Box box = inner > 0 ? work.changed : Box{};
  const bool changed = !box.is_empty() && y >= box.top && y < box.bottom;
  if (changed) light_row(work, y);
  detail::vectorised([&] {
    for (std::size_t c = 0; c < 3 && inner > 0; ++c) {
      T* const sum = work.seen[c].data();
      const T *const at_rest = rest_light_.data() + offset(y, c), *const lit = work.lit[c].data();
      const Index left = changed ? box.left : camera_.width;
      const Index right = changed ? box.right : camera_.width;
      detail::add_scaled(sum, at_rest, inner, left);
      detail::add_scaled(sum + left, lit + left, inner, right - left);
      detail::add_scaled(sum + right, at_rest + right, inner, camera_.width - right);
    }
    detail::pack_row(work.packed.data(), work.seen[0].data(), work.seen[1].data(),
                     work.seen[2].data(), camera_.width);
    detail::write_run(out, work.packed.data(), y, {0, camera_.width});
  });
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class SeeThroughRenderer<float>;
template class SeeThroughRenderer<double>;
}  // namespace gelight
#endif
