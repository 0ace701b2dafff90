#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/normal_rows.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/rows/lines.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/shading/phong_row.hpp"
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

/// By how much N.L may be rounded, of a membrane's normal from its depths as a camera sees them and
/// a direction to a light: of a light along the membrane the sign is unknown, and with it the
/// gloss.
template <std::floating_point T>
[[nodiscard]] T facing_rounding(const Camera<T>& camera) {
  // A coordinate of a normal is rounded some five times on the way, one of a direction twice, and
  // their sum of products five times.
  constexpr T roundings = 16;
  // Sums of two depths are rounded before their difference is taken, which over twice the depth
  // and times the focal length is a slope.
  const T of_slopes = std::max(camera.fx, camera.fy);
  // Coordinates are as long as the rays at most, which are longest in a corner.
  T longest = 0;
  for (const Index y : {Index{0}, camera.height - 1}) {
    for (const Index x : {Index{0}, camera.width - 1}) {
      longest = std::max(longest, norm(camera.ray(static_cast<T>(x), static_cast<T>(y))));
    }
  }
  return (roundings + of_slopes) * std::numeric_limits<T>::epsilon() * longest;
}

/// The colours of a membrane, up to a tile of a row at a time: background and lights, which do not
/// change from frame to frame, on normals that do. In shares of 255, so that they need only be
/// truncated.
template <std::floating_point T>
class ShadedRows {
 public:
  struct Workspace {
    struct alignas(line_bytes) Row : std::array<T, tile_width> {};
    Row normal_x, normal_y, normal_z, toward, mirrored, shine;
    std::array<Row, 3> rgb;
    Lines<std::int32_t> packed;  // a row of the image
  };

  /// `rectified_to` are the membrane's normals at rest if the lights' directions shall be made
  /// tangent to it and of unit length, or null; where they keep their strength, of theirs.
  ShadedRows(const Camera<T>& camera, const Background<T>& background, double ambient,
             const std::vector<Light<T>>& lights, Specular form,
             const Image<Vec3<double>>* rectified_to, bool keep_strength = false)
      : camera_(camera),
        columns_(ray_columns(camera)),
        tiles_((camera.width + tile_width - 1) / tile_width),
        planes_(is_grey(background) ? 2 : 4),
        coordinates_(3 * static_cast<std::ptrdiff_t>(lights.size())) {
    const auto tiles = static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(camera.height);
    const auto coordinates = tiles * static_cast<std::size_t>(coordinates_);
    fixed_.resize(tiles * static_cast<std::size_t>(planes_ * tile_width));
    codes_.resize(coordinates * tile_width);
    ranges_.resize(coordinates);
    columns_.resize(static_cast<std::size_t>(whole_blocks(camera.width)));
    keep_rays();
    keep_background(background, static_cast<T>(255 * ambient));
    for (std::size_t k = 0; k < lights.size(); ++k) {
      const T least_seen = keep_direction(lights[k].direction, k, rectified_to, keep_strength);
      keep_colour(lights[k], form, form == Specular::gated ? least_seen : 0);
    }
  }

  [[nodiscard]] Workspace make_workspace() const {
    Workspace work{};
    work.packed.resize(static_cast<std::size_t>(whole_blocks(camera_.width)));
    return work;
  }

  /// The normals of a run of row y within a tile, from the depths of that row and its two
  /// neighbours, in the coordinates that phong_row wants.
  [[nodiscard]] VectorRow<T> normals(Workspace& work, Index y, const Run& run, const T* above,
                                     const T* middle, const T* below) const {
    const std::ptrdiff_t x = run.begin;
    const VectorRow<T> n{work.normal_x.data(), work.normal_y.data(), work.normal_z.data()};
    vectorised([&] {
      const std::ptrdiff_t count = whole_blocks(run.end - run.begin);
      sobel_product_row(n.x, n.y, n.z, work.toward.data(), work.mirrored.data(), above + x,
                        middle + x, below + x, camera_.fx, camera_.fy, count);
      unit_facet_row(n.x, n.y, n.z, rays(y, run), count);
    });
    return n;
  }

  /// The colours of a run of row y within a tile with these normals, into `packed`; `kept` is the
  /// share of the ambient light that is left at each pixel of the row, or null for all of it.
  void shade(Workspace& work, Index y, const Run& run, const VectorRow<T>& n, const T* kept) const {
    vectorised([&] {
      const auto rgb = light(work, y, run, n, kept);
      pack_row(work.packed.data() + run.begin, rgb[0], rgb[1], rgb[2],
               std::ptrdiff_t{whole_blocks(run.end - run.begin)});
    });
  }

  /// The same before they are clamped and truncated: red, green and blue of the run's pixels.
  [[nodiscard]] std::array<const T*, 3> light(Workspace& work, Index y, const Run& run,
                                              const VectorRow<T>& n, const T* kept) const {
    const std::ptrdiff_t count = whole_blocks(run.end - run.begin);
    std::array<const T*, 3> sum{};
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] = ambient(run.begin, y, c);
      if (kept == nullptr) continue;
      multiply_rows(work.rgb[c].data(), sum[c], kept + run.begin, count);
      sum[c] = work.rgb[c].data();
    }
    const PhongScratch<T> scratch{work.toward.data(), work.mirrored.data(), work.shine.data()};
    for (std::size_t k = 0; k < colours_.size(); ++k) {
      const auto first = static_cast<std::ptrdiff_t>(3 * k);
      const LightRow<T> light{coded(run.begin, y, first), coded(run.begin, y, first + 1),
                              coded(run.begin, y, first + 2)};
      phong_row(scratch, FacetRow<T>{n.x, n.y, n.z}, light, colours_[k], count);
      for (std::size_t c = 0; c < 3; ++c) {
        if (colours_[k].diffuse[c] == 0 && colours_[k].specular[c] == 0) continue;
        T* const out = work.rgb[c].data();
        const T diffuse = colours_[k].diffuse[c], specular = colours_[k].specular[c];
        add_light_row(out, sum[c], scratch, diffuse, specular, count);
        sum[c] = out;
      }
    }
    return sum;
  }

  /// The colour of a pixel by ambient light alone, packed.
  [[nodiscard]] std::int32_t ambient_colour(Index x, Index y) const {
    return to_byte(*ambient(x, y, 0)) | to_byte(*ambient(x, y, 1)) << 8 |
           to_byte(*ambient(x, y, 2)) << 16;
  }

 private:
  using Code = typename CodedRow<T>::Code;
  struct Range {
    T least, step;
  };

  // The planes of `fixed_`.
  static constexpr std::ptrdiff_t inverse_ray_plane = 0, red_plane = 1;

  [[nodiscard]] std::ptrdiff_t tile(Index x, Index y) const {
    return std::ptrdiff_t{y} * tiles_ + x / tile_width;
  }
  // Pixel (x, y) of a plane, and the pixels of its tile after it.
  [[nodiscard]] const T* fixed(Index x, Index y, std::ptrdiff_t plane) const {
    return fixed_.data() + (tile(x, y) * planes_ + plane) * tile_width + x % tile_width;
  }
  [[nodiscard]] T& fixed(Index x, Index y, std::ptrdiff_t plane) {
    return const_cast<T&>(*std::as_const(*this).fixed(x, y, plane));
  }
  [[nodiscard]] const T* ambient(Index x, Index y, std::size_t c) const {
    return fixed(x, y, planes_ == 2 ? red_plane : red_plane + static_cast<std::ptrdiff_t>(c));
  }
  [[nodiscard]] RayRow<T> rays(Index y, const Run& run) const {
    return {columns_.data() + run.begin, fixed(run.begin, y, inverse_ray_plane),
            camera_.ray(0, static_cast<T>(y)).y()};
  }
  // The lights' coordinate from pixel (x, y) on: x, y, z of the first light, then of the second.
  [[nodiscard]] CodedRow<T> coded(Index x, Index y, std::ptrdiff_t coordinate) const {
    const std::ptrdiff_t at = tile(x, y) * coordinates_ + coordinate;
    const Range& range = ranges_[static_cast<std::size_t>(at)];
    return {codes_.data() + at * tile_width + x % tile_width, range.least, range.step};
  }

  [[nodiscard]] static bool is_grey(const Background<T>& background) {
    const auto grey = [](const std::array<T, 3>& p) { return p[0] == p[1] && p[1] == p[2]; };
    const auto& pixels = background.image().pixels();
    return background.is_image() ? std::all_of(pixels.begin(), pixels.end(), grey)
                                 : grey(background.solid());
  }

  void keep_rays() {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        fixed(x, y, inverse_ray_plane) =
            1 / norm(camera_.ray(static_cast<T>(x), static_cast<T>(y)));
      }
    }
  }

  void keep_background(const Background<T>& background, T scale) {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        const auto& rgb = background.is_image() ? background.image()(x, y) : background.solid();
        for (std::ptrdiff_t plane = red_plane; plane < planes_; ++plane) {
          fixed(x, y, plane) = scale * rgb[static_cast<std::size_t>(plane - red_plane)];
        }
      }
    }
  }

  // Returns by how much the product of a unit normal with a kept direction may be rounded.
  T keep_direction(const Image<Vec3<T>>& travel, std::size_t k,
                   const Image<Vec3<double>>* rectified_to, bool keep_strength) {
    const auto camera = camera_.template cast<double>();
    T steps = 0;
    std::array<std::array<double, tile_width>, 3> planes{};
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index begin = 0; begin < camera_.width; begin += tile_width) {
        const Index count = std::min(tile_width, camera_.width - begin);
        for (Index i = 0; i < count; ++i) {
          Vec3<double> l = -cast<double>(travel(begin + i, y));
          if (rectified_to != nullptr) {
            const Vec3<double>& normal = (*rectified_to)(begin + i, y);
            const double strength = keep_strength ? norm(l) : 1;
            // Twice: what is left of a direction along the normal is rounded by as much as that.
            for (int pass = 0; pass < 2; ++pass) l = stable_unit(l - dot(l, normal) * normal);
            l *= strength;
          }
          const Vec3<double> ray = camera.ray(begin + i, y);
          const auto at = static_cast<std::size_t>(i);
          planes[0][at] = l.x() - ray.x() * l.z();
          planes[1][at] = l.y() - ray.y() * l.z();
          planes[2][at] = dot(l, ray) / norm(ray);
        }
        T step = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const auto coordinate = static_cast<std::ptrdiff_t>(3 * k + c);
          const auto at = static_cast<std::size_t>(tile(begin, y) * coordinates_ + coordinate);
          encode({planes[c].data(), static_cast<std::size_t>(count)}, at);
          if (!std::same_as<T, Code>) step += ranges_[at].step;
        }
        steps = std::max(steps, step);
      }
    }
    return steps / 2 + facing_rounding(camera_);  // half a step of each coordinate's code
  }

  // Keeps a tile of a coordinate of a light.
  void encode(std::span<const double> values, std::size_t at) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const auto low = static_cast<T>(*least);
    const T step = std::same_as<T, Code> ? 1 : std::max(T(0), static_cast<T>(*most) - low) / 65535;
    ranges_[at] = {std::same_as<T, Code> ? 0 : low, step};
    for (std::size_t i = 0; i < values.size(); ++i) {
      Code& code = codes_[at * tile_width + i];
      if constexpr (std::same_as<T, Code>) {
        code = static_cast<T>(values[i]);
      } else {
        const double steps = step > 0 ? (values[i] - double{low}) / double{step} : 0;
        code = static_cast<Code>(std::clamp(std::round(steps), 0.0, 65535.0));
      }
    }
  }

  void keep_colour(const Light<T>& light, Specular form, T tangent) {
    const T least = std::pow(std::numeric_limits<T>::min(), 1 / std::max(T(1), light.shininess));
    LightColour<T> colour{{}, {}, light.shininess, form, least, tangent};
    for (std::size_t c = 0; c < 3; ++c) {
      colour.diffuse[c] = 255 * light.rgb[c] * light.diffuse;
      colour.specular[c] = 255 * light.rgb[c] * light.specular;
    }
    colours_.push_back(colour);
  }

  Camera<T> camera_;
  std::vector<T> columns_;
  std::ptrdiff_t tiles_, planes_, coordinates_;  // tiles in a row; the others in a tile
  // Tile after tile, and in each plane after plane: read from end to end.
  Lines<T> fixed_;
  Lines<Code> codes_;
  Array<Range> ranges_;  // of each tile and coordinate
  Array<LightColour<T>> colours_;
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::ShadedRows<float>;
GELIGHT_ONCE template class detail::ShadedRows<double>;
}  // namespace gelight
#endif
