#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/detail/normal_rows.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/detail/row_runs.hpp"
#include "gelight/shading/detail/phong_row.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// Clamps to [0, 255] and truncates; what is not a number becomes 0.
template <std::floating_point T>
[[nodiscard]] std::int32_t to_byte(T value) {
  const T at_least = value > 0 ? value : 0;
  return static_cast<std::int32_t>(at_least < 255 ? at_least : T(255));
}

/// Red, green and blue in one number, from the lowest byte up.
template <class T>
void pack_row(std::int32_t* __restrict packed, const T* r, const T* g, const T* b,
              std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    packed[i] = to_byte(r[i]) | to_byte(g[i]) << 8 | to_byte(b[i]) << 16;
  }
}

/// Turns protrusions into the share of light that is left: 1 - most at `full` or more.
template <class T>
void keep_row(T* __restrict row, T most, T full, std::ptrdiff_t count) {
  const T slope = most / full;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T pressed = row[i] > 0 ? row[i] : 0;
    const T lost = slope * pressed;
    row[i] = 1 - (lost < most ? lost : most);
  }
}

template <class T>
void multiply_rows(T* __restrict out, const T* a, const T* b, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = a[i] * b[i];
}

/// The colours of a membrane, a run of a row at a time: background and lights, which do not change
/// from frame to frame, on normals that do. In shares of 255, so that they need only be truncated.
template <std::floating_point T>
class ShadedRows {
 public:
  struct Workspace {
    std::vector<T> normal_x, normal_y, normal_z, facing;  // a row each
    std::vector<T> toward, mirrored, shine;
    std::array<std::vector<T>, 3> rgb;
    std::vector<std::int32_t> packed;
  };

  ShadedRows(const Camera<T>& camera, const Background<T>& background, double ambient,
             const std::vector<Light<T>>& lights, Specular form)
      : camera_(camera), columns_(ray_columns(camera)), planes_(first_light + 3 * lights.size()) {
    fixed_.resize(planes_ * static_cast<std::size_t>(camera.width) *
                  static_cast<std::size_t>(camera.height));
    keep_rays();
    keep_background(background, static_cast<T>(255 * ambient));
    for (std::size_t k = 0; k < lights.size(); ++k) keep_light(lights[k], k, form);
  }

  /// Makes the lights' directions tangent to the surface with these normals, and of unit length.
  void rectify(const Image<Vec3<double>>& normals) {
    for (std::size_t k = 0; k < colours_.size(); ++k) {
      for (Index y = 0; y < camera_.height; ++y) {
        T *const lx = fixed(y, light_plane(k)), *const ly = fixed(y, light_plane(k) + 1),
                 *const lz = fixed(y, light_plane(k) + 2);
        for (Index x = 0; x < camera_.width; ++x) {
          Vec3<double> to_light(lx[x], ly[x], lz[x]);
          to_light -= to_light.dot(normals(x, y)) * normals(x, y);
          to_light.stableNormalize();
          lx[x] = static_cast<T>(to_light.x());
          ly[x] = static_cast<T>(to_light.y());
          lz[x] = static_cast<T>(to_light.z());
        }
      }
    }
  }

  [[nodiscard]] Workspace make_workspace() const {
    Workspace work;
    const auto width = static_cast<std::size_t>(camera_.width);
    for (auto* row : {&work.normal_x, &work.normal_y, &work.normal_z, &work.facing, &work.toward,
                      &work.mirrored, &work.shine, &work.rgb[0], &work.rgb[1], &work.rgb[2]}) {
      row->resize(width);
    }
    work.packed.resize(width);
    return work;
  }

  /// The normals of a run of row y, from the depths of that row and its two neighbours.
  [[nodiscard]] NormalRow<T> normals(Workspace& work, Index y, const Run& run, const T* above,
                                     const T* middle, const T* below) const {
    const std::ptrdiff_t x = run.begin;
    const NormalRow<T> n{work.normal_x.data() + x, work.normal_y.data() + x,
                         work.normal_z.data() + x, work.facing.data() + x};
    const RayRow<T> ray{columns_.data() + x, row_ray(y), camera_.fx, camera_.fy};
    sobel_normal_row(n, above + x, middle + x, below + x, ray, run.end - run.begin);
    return n;
  }

  /// The colours of a run of row y with these normals, into `packed`; `kept` is the share of the
  /// ambient light that is left at each pixel of the row, or null for all of it.
  void shade(Workspace& work, Index y, const Run& run, const NormalRow<T>& n, const T* kept) const {
    const auto rgb = light(work, y, run, n, kept);
    pack_row(work.packed.data() + run.begin, rgb[0], rgb[1], rgb[2], run.end - run.begin);
  }

  /// The same before they are clamped and truncated: red, green and blue of the run's pixels.
  [[nodiscard]] std::array<const T*, 3> light(Workspace& work, Index y, const Run& run,
                                              const NormalRow<T>& n, const T* kept) const {
    const std::ptrdiff_t x = run.begin, count = run.end - run.begin;
    std::array<const T*, 3> sum{ambient(y, 0) + x, ambient(y, 1) + x, ambient(y, 2) + x};
    for (std::size_t c = 0; c < 3 && kept != nullptr; ++c) {
      T* const out = work.rgb[c].data() + x;
      multiply_rows(out, sum[c], kept + x, count);
      sum[c] = out;
    }
    const EyeRow<T> eye{columns_.data() + x, fixed(y, inverse_ray_plane) + x, row_ray(y)};
    const PhongScratch<T> scratch{work.toward.data() + x, work.mirrored.data() + x,
                                  work.shine.data() + x};
    for (std::size_t k = 0; k < colours_.size(); ++k) {
      const std::size_t plane = light_plane(k);
      const LightRow<T> light{fixed(y, plane) + x, fixed(y, plane + 1) + x,
                              fixed(y, plane + 2) + x};
      phong_row(scratch, n, light, colours_[k], eye, count);
      for (std::size_t c = 0; c < 3; ++c) {
        if (colours_[k].diffuse[c] == 0 && colours_[k].specular[c] == 0) continue;
        T* const out = work.rgb[c].data() + x;
        add_light_row(out, sum[c], scratch, colours_[k].diffuse[c], colours_[k].specular[c], count);
        sum[c] = out;
      }
    }
    return sum;
  }

  /// The colour of a pixel by ambient light alone, packed.
  [[nodiscard]] std::int32_t ambient_colour(Index x, Index y) const {
    return to_byte(ambient(y, 0)[x]) | to_byte(ambient(y, 1)[x]) << 8 |
           to_byte(ambient(y, 2)[x]) << 16;
  }

 private:
  // The planes of `fixed_`.
  static constexpr std::size_t inverse_ray_plane = 0, red_plane = 1, first_light = 4;

  [[nodiscard]] static std::size_t light_plane(std::size_t k) { return first_light + 3 * k; }
  [[nodiscard]] std::ptrdiff_t offset(Index y, std::size_t plane) const {
    return (static_cast<std::ptrdiff_t>(plane) * camera_.height + y) * camera_.width;
  }
  [[nodiscard]] T* fixed(Index y, std::size_t plane) { return fixed_.data() + offset(y, plane); }
  [[nodiscard]] const T* fixed(Index y, std::size_t plane) const {
    return fixed_.data() + offset(y, plane);
  }
  [[nodiscard]] const T* ambient(Index y, std::size_t c) const {
    return fixed(y, grey_background_ ? red_plane : red_plane + c);
  }
  [[nodiscard]] T row_ray(Index y) const { return camera_.ray(0, static_cast<T>(y)).y(); }

  void keep_rays() {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        fixed(y, inverse_ray_plane)[x] =
            1 / camera_.ray(static_cast<T>(x), static_cast<T>(y)).norm();
      }
    }
  }

  void keep_background(const Background<T>& background, T scale) {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        const auto& rgb = background.is_image() ? background.image()(x, y) : background.solid();
        for (std::size_t c = 0; c < 3; ++c) fixed(y, red_plane + c)[x] = scale * rgb[c];
        grey_background_ = grey_background_ && rgb[0] == rgb[1] && rgb[1] == rgb[2];
      }
    }
  }

  void keep_light(const Light<T>& light, std::size_t k, Specular form) {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          fixed(y, light_plane(k) + c)[x] = -light.direction(x, y)[static_cast<Index>(c)];
        }
      }
    }
    const T least = std::pow(std::numeric_limits<T>::min(), 1 / std::max(T(1), light.shininess));
    LightColour<T> colour{{}, {}, light.shininess, form, least};
    for (std::size_t c = 0; c < 3; ++c) {
      colour.diffuse[c] = 255 * light.rgb[c] * light.diffuse;
      colour.specular[c] = 255 * light.rgb[c] * light.specular;
    }
    colours_.push_back(colour);
  }

  Camera<T> camera_;
  std::vector<T> columns_;
  std::size_t planes_;
  std::vector<T> fixed_;  // plane after plane
  bool grey_background_ = true;
  std::vector<LightColour<T>> colours_;
};

}  // namespace gelight::detail
