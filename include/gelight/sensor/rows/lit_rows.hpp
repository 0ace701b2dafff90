#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/plane_fit_rows.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/shading/phong_row.hpp"

namespace gelight::detail {

/// The two terms of Phong's equation for a light along a row: N.L where it is more than `tangent`,
/// and R.V before its power, 0 where it is not above `least`.
template <class T>
void face_light(T* __restrict toward, T* __restrict mirrored, const DirectionRow<T>& n,
                const std::array<const T*, 3>& to_light, const T* u, T v, const T* inverse_ray,
                T tangent, T least, std::ptrdiff_t count) {
  const T *const nx = n.x, *const ny = n.y, *const nz = n.z, *const facing = n.facing;
  const T *const lx = to_light[0], *const ly = to_light[1], *const lz = to_light[2];
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T cosine = nx[i] * lx[i] + ny[i] * ly[i] + nz[i] * lz[i];
    const T lit = (cosine + std::abs(cosine)) / 2;  // exactly max(0, cosine), and vectorised
    toward[i] = lit;
    mirrored[i] = inverse_ray[i] * (lx[i] * u[i] + ly[i] * v + lz[i] - 2 * lit * facing[i]);
  }
  for (std::ptrdiff_t i = 0; i < count; ++i) toward[i] = toward[i] > tangent ? toward[i] : 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) mirrored[i] = mirrored[i] > least ? mirrored[i] : 0;
}

/// shine[i] = 0 where the light is behind the surface.
template <class T>
void keep_lit(T* __restrict shine, const T* toward, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) shine[i] = toward[i] > 0 ? shine[i] : 0;
}

template <class T>
void add_terms(T* __restrict sum, const T* toward, const T* shine, T diffuse, T specular,
               std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) sum[i] += diffuse * toward[i] + specular * shine[i];
}

/// Phong's equation for some lights, a run of a row at a time, on unit normals. A
/// light along the membrane has an N.L of up to `tangent`, by rounding alone, and counts for none.
template <std::floating_point T>
class LitRows {
 public:
  struct Workspace {
    std::vector<T> toward, mirrored, shine;
    std::array<std::vector<T>, 3> rgb;  // a row each
  };

  LitRows(const Camera<T>& camera, T ambient, const std::vector<Light<T>>& lights, T tangent)
      : camera_(camera), ambient_(ambient), tangent_(tangent), planes_(1 + 3 * lights.size()) {
    fixed_.resize(planes_ * static_cast<std::size_t>(camera.width) *
                  static_cast<std::size_t>(camera.height));
    for (Index x = 0; x < camera.width; ++x) {
      columns_.push_back(camera.ray(static_cast<T>(x), 0).x());
    }
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        plane(y, 0)[x] = 1 / norm(camera.ray(static_cast<T>(x), static_cast<T>(y)));
      }
    }
    for (std::size_t k = 0; k < lights.size(); ++k) keep(lights[k], k);
  }

  [[nodiscard]] Workspace make_workspace() const {
    const std::vector<T> row(static_cast<std::size_t>(camera_.width));
    return {row, row, row, {row, row, row}};
  }

  /// The sum of all lights, with 1 for full light; the normals' rows begin with the run.
  [[nodiscard]] std::array<T*, 3> light(Workspace& work, Index y, const Run& run,
                                        const DirectionRow<T>& n) const {
    const std::ptrdiff_t x = run.begin, count = run.end - run.begin;
    std::array<T*, 3> sum{};
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] = work.rgb[c].data() + x;
      std::fill_n(sum[c], count, ambient_);
    }
    T *const toward = work.toward.data(), *const shine = work.shine.data();
    for (std::size_t k = 0; k < lights_.size(); ++k) {
      const std::array<const T*, 3> to_light{plane(y, 3 * k + 1) + x, plane(y, 3 * k + 2) + x,
                                             plane(y, 3 * k + 3) + x};
      face_light(toward, work.mirrored.data(), n, to_light, columns_.data() + x,
                 camera_.ray(0, static_cast<T>(y)).y(), plane(y, 0) + x, tangent_, lights_[k].least,
                 count);
      raise(shine, work.mirrored.data(), lights_[k].shininess, count);
      keep_lit(shine, toward, count);
      for (std::size_t c = 0; c < 3; ++c) {
        const T diffuse = lights_[k].diffuse[c], specular = lights_[k].specular[c];
        if (diffuse == 0 && specular == 0) continue;
        add_terms(sum[c], toward, shine, diffuse, specular, count);
      }
    }
    return sum;
  }

 private:
  struct Colour {
    std::array<T, 3> diffuse, specular;
    T shininess;
    T least;  // cosines of which the power is no normal number are taken for 0
  };

  static void raise(T* power, T* base, T exponent, std::ptrdiff_t count) {
    if (exponent == std::floor(exponent) && exponent < T(1u << 31)) {
      integer_power_row(power, base, static_cast<unsigned>(exponent), count);
    } else {
      real_power_row(power, base, exponent, count);
    }
  }

  void keep(const Light<T>& light, std::size_t k) {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          plane(y, 3 * k + 1 + c)[x] = -light.direction(x, y)[static_cast<Index>(c)];
        }
      }
    }
    const T least = std::pow(std::numeric_limits<T>::min(), 1 / std::max(T(1), light.shininess));
    Colour colour{{}, {}, light.shininess, least};
    for (std::size_t c = 0; c < 3; ++c) {
      colour.diffuse[c] = light.rgb[c] * light.diffuse;
      colour.specular[c] = light.rgb[c] * light.specular;
    }
    lights_.push_back(colour);
  }

  // Row y of a plane: one over the length of the rays, then directions to the lights.
  [[nodiscard]] std::size_t offset(Index y, std::size_t plane) const {
    return (plane * static_cast<std::size_t>(camera_.height) + static_cast<std::size_t>(y)) *
           static_cast<std::size_t>(camera_.width);
  }
  [[nodiscard]] T* plane(Index y, std::size_t plane) { return fixed_.data() + offset(y, plane); }
  [[nodiscard]] const T* plane(Index y, std::size_t plane) const {
    return fixed_.data() + offset(y, plane);
  }

  Camera<T> camera_;
  T ambient_, tangent_;
  std::size_t planes_;
  std::vector<T> columns_, fixed_;
  Array<Colour> lights_;
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::LitRows<float>;
GELIGHT_ONCE template class detail::LitRows<double>;
}  // namespace gelight
#endif
