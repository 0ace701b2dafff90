#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "gelight/concepts/reflectance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/normal_rows.hpp"
#include "gelight/sensor/rows/lines.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/sensor/rows/shaded_rows.hpp"

namespace gelight::detail {

/// Whether a reflectance asks where an object touches the gel.
template <class Shine>
[[nodiscard]] constexpr bool reads_touched() {
  if constexpr (requires { Shine::reads_touched; }) return Shine::reads_touched;
  return false;
}

/// The colours of a membrane of any reflectance, up to a tile of a row at a time.
template <std::floating_point T, Reflectance<T> R>
class ModelShading {
 public:
  struct Workspace {
    struct alignas(line_bytes) Row : std::array<T, tile_width> {};
    Row normal_x, normal_y, normal_z, sum, difference;
    std::array<Row, 3> rgb;
    Lines<std::int32_t> packed;  // a row of the image
  };

  ModelShading(const Camera<T>& camera, R model)
      : camera_(camera), columns_(ray_columns(camera)), model_(std::move(model)) {
    if constexpr (requires { model_.require_fits(camera); }) model_.require_fits(camera);
  }

  [[nodiscard]] Workspace make_workspace() const {
    Workspace work{};
    work.packed.resize(static_cast<std::size_t>(camera_.width));
    return work;
  }

  /// The unit normals of a run of row y within a tile, from the depths of that row and its two
  /// neighbours.
  [[nodiscard]] VectorRow<T> normals(Workspace& work, Index y, const Run& run, const T* above,
                                     const T* middle, const T* below) const {
    const std::ptrdiff_t x = run.begin, count = run.end - run.begin;
    const VectorRow<T> n{work.normal_x.data(), work.normal_y.data(), work.normal_z.data()};
    const RayRow<T> rays{columns_.data() + x, nullptr, camera_.ray(0, static_cast<T>(y)).y()};
    vectorised([&] {
      sobel_product_row(n.x, n.y, n.z, work.sum.data(), work.difference.data(), above + x,
                        middle + x, below + x, camera_.fx, camera_.fy, count);
      unit_normal_row(n.x, n.y, n.z, rays, count);
    });
    return n;
  }

  /// The colours of a run of row y within a tile with these normals, into `packed`; `kept` is the
  /// share of the ambient light that is left at each pixel of the row, or null for all of it,
  /// `touched` not zero where an object touches, or null.
  void shade(Workspace& work, Index y, const Run& run, const VectorRow<T>& n, const T* kept,
             const T* touched = nullptr) const {
    const std::ptrdiff_t count = run.end - run.begin;
    const T* const kept_here = kept != nullptr ? kept + run.begin : nullptr;
    auto& [r, g, b] = work.rgb;
    const ColourRow<T> out{r.data(), g.data(), b.data()};
    const SurfaceRow<T> row{
        run.begin, y,   count,     n.x,
        n.y,       n.z, kept_here, touched != nullptr ? touched + run.begin : nullptr};
    std::int32_t* const packed = work.packed.data() + run.begin;
    vectorised([&] {
      model_.shade_row(out, row);
      pack_shares(packed, out, count);
    });
  }

  /// The colour of a pixel by ambient light alone, packed.
  [[nodiscard]] std::int32_t ambient_colour(Index x, Index y) const {
    const T zero = 0;
    T r = 0, g = 0, b = 0;
    const ColourRow<T> out{&r, &g, &b};
    const T* const touched = reads_touched<R>() ? &zero : nullptr;
    model_.shade_row(out, SurfaceRow<T>{x, y, 1, &zero, &zero, &zero, nullptr, touched});
    std::int32_t packed = 0;
    pack_shares(&packed, out, 1);
    return packed;
  }

 private:
  static void pack_shares(std::int32_t* __restrict packed, const ColourRow<T>& rgb,
                          std::ptrdiff_t count) {
    const T *const r = rgb.r, *const g = rgb.g, *const b = rgb.b;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      packed[i] = to_byte(255 * r[i]) | to_byte(255 * g[i]) << 8 | to_byte(255 * b[i]) << 16;
    }
  }

  Camera<T> camera_;
  std::vector<T> columns_;
  R model_;
};

}  // namespace gelight::detail
