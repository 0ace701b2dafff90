#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/shading/phong_row.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// How a TactileRenderer turns a depth map into an image.
struct TactileOptions {
  /// Standard deviation, in pixels, of the Gaussian that spreads a protrusion over the membrane;
  /// 0 is a membrane that follows the object exactly.
  double smoothing_sigma = 5;
  /// Where that Gaussian is cut off, in pixels.
  Index smoothing_radius = 20;
  /// Make the lights' directions tangent to the membrane at rest, and of unit length.
  bool rectify = false;
  /// Take what lies deeper than the membrane at rest as not touching it, rather than as pulling it.
  bool clip_to_rest = true;
  /// The share of the background that is seen without any light.
  double ambient = 0.5;
  Specular specular = Specular::gated;
  /// The published images have no normals on the outermost pixels: these show ambient light alone.
  BorderNormals border_normals = BorderNormals::none;

  /// The options with which the GelTip authors' published images come out: for all their light
  /// fields but the linear one `rectify` is true.
  [[nodiscard]] static TactileOptions as_published(bool rectify) {
    TactileOptions options;
    options.rectify = rectify;
    options.clip_to_rest = false;
    options.specular = Specular::unclamped;
    return options;
  }
};

namespace detail {

/// Planes of numbers, several for each row of an image, those of one row side by side.
template <class T>
class RowPlanes {
 public:
  RowPlanes() = default;
  RowPlanes(Index width, Index height, Index planes)
      : width_(width),
        planes_(planes),
        data_(static_cast<std::size_t>(width) * static_cast<std::size_t>(planes) *
              static_cast<std::size_t>(height)) {}
  [[nodiscard]] T* row(Index y, Index plane) { return data_.data() + offset(y, plane); }
  [[nodiscard]] const T* row(Index y, Index plane) const { return data_.data() + offset(y, plane); }

 private:
  [[nodiscard]] std::ptrdiff_t offset(Index y, Index plane) const {
    return (std::ptrdiff_t{y} * planes_ + plane) * width_;
  }
  Index width_ = 0, planes_ = 0;
  std::vector<T> data_;
};

/// Objects that calls borrow, made when none is free; a copy of the store starts empty.
template <class Item>
class Store {
 public:
  Store() = default;
  Store(const Store&) {}
  Store& operator=(const Store&) { return *this; }

  template <class Make>
  [[nodiscard]] std::unique_ptr<Item> take(const Make& make) {
    {
      const std::lock_guard lock(mutex_);
      if (!items_.empty()) {
        auto item = std::move(items_.back());
        items_.pop_back();
        return item;
      }
    }
    return make();
  }

  void give_back(std::unique_ptr<Item> item) {
    const std::lock_guard lock(mutex_);
    items_.push_back(std::move(item));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Item>> items_;
};

template <std::floating_point T>
[[nodiscard]] bool is_depth(T z) {
  return z > 0 && z <= std::numeric_limits<T>::max();
}

/// Copies row y of an image, converted.
template <std::floating_point T, ImageOf<T> I>
void read_row(const I& image, Index y, T* out, Index width) {
  for (Index x = 0; x < width; ++x) out[x] = static_cast<T>(ImageTraits<I>::pixel(image, x, y));
}

/// Clamps to [0, 255] and truncates; what is not a number becomes 0.
template <std::floating_point T>
[[nodiscard]] std::int32_t to_byte(T value) {
  const T at_least = value > 0 ? value : 0;
  return static_cast<std::int32_t>(at_least < 255 ? at_least : T(255));
}

/// Red, green and blue, from the lowest byte up.
template <class T>
void pack_row(std::int32_t* __restrict packed, const T* r, const T* g, const T* b,
              std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    packed[i] = to_byte(r[i]) | to_byte(g[i]) << 8 | to_byte(b[i]) << 16;
  }
}

}  // namespace detail

/// Renders the image that the camera inside an optical tactile sensor takes of its lit membrane.
///
/// For every frame: the membrane is pressed in by whatever is nearer than its rest depth, and
/// bulges around it by a Gaussian of the protrusion, min(depth, rest - G(rest - depth)); its
/// points' Sobel derivatives give the normals; Phong's equation adds up the lights over a share of
/// the background; the sum is clamped to [0, 1] and truncated to 8 bits. (Gomes, Paoletti, Luo,
/// Simulation of Curved GelSight Sensors for Sim2Real Learning)
///
/// A depth that is NaN, infinite, zero or negative is not known: its pixel shows ambient light
/// alone, and the protrusion around it is averaged over the known pixels only, so that it does not
/// spread; the membrane's neighbouring normals take it to be where the average puts it. A rest
/// depth that is not known is a pixel outside the membrane: it and the normals beside it are
/// without light. A frame that equals the rest depth (or has nothing nearer) gives `rest_image()`
/// bit for bit.
///
/// Everything that does not depend on the frame is computed once. `render` may be called from
/// several threads; each borrows a workspace, so that after its first frame none allocates.
template <std::floating_point T>
class TactileRenderer {
 public:
  /// Throws InvalidInput for a camera that is not valid, an image that has another size than the
  /// camera's, a light or background with a number that is not finite, options out of range, and an
  /// unclamped specular term with a shininess that is not an integer.
  template <ImageOf<T> D>
  TactileRenderer(const Camera<T>& camera, const D& rest_depth, const std::vector<Light<T>>& lights,
                  const Background<T>& background = {}, const TactileOptions& options = {})
      : camera_(camera),
        options_(options),
        radius_(options.smoothing_sigma > 0 ? options.smoothing_radius : 0),
        window_(2 * radius_ + 1),
        weights_(gaussian_weights<T>(options.smoothing_sigma, options.smoothing_radius)) {
    check(rest_depth, lights, background);
    zeros_.resize(static_cast<std::size_t>(camera.width));
    columns_ = detail::ray_columns(camera);
    fixed_ = detail::RowPlanes<T>(camera.width, camera.height, light_plane(lights.size()));
    keep_rest(rest_depth);
    keep_background(background);
    keep_lights(lights);
    rest_image_ = Image<Rgb8>(camera.width, camera.height);
    render_rows(rest_image_.view(), rest_depth);
  }

  [[nodiscard]] const Camera<T>& camera() const { return camera_; }
  [[nodiscard]] const TactileOptions& options() const { return options_; }

  /// The image of the membrane that nothing touches.
  [[nodiscard]] const Image<Rgb8>& rest_image() const { return rest_image_; }

  /// The image of a depth map of what touches the membrane, in the unit of the rest depth.
  /// Throws InvalidInput for a depth image of another size than the camera's.
  template <ImageOf<T> D>
  [[nodiscard]] Image<Rgb8> render(const D& depth) const {
    Image<Rgb8> out(camera_.width, camera_.height);
    render_into(out, depth);
    return out;
  }

  /// The same, into the caller's pixels. Throws InvalidInput, before anything is written, for a
  /// depth or output image of another size than the camera's.
  template <ImageOf<T> D>
  void render_into(ImageView<Rgb8> out, const D& depth) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    detail::require_camera_size(out, camera_, "the output image");
    render_rows(out, depth);
  }

 private:
  struct Workspace {
    std::vector<T> padded;      // a row of protrusion, `radius_` more on each side
    std::vector<T> protrusion;  // rows of it, smoothed along the row: row y at y mod window
    std::vector<T> missing;     // rows of 1 where the depth is not known, smoothed likewise
    std::vector<T> membrane;    // rows of depth, one pixel more on each side: row y at y mod 3
    std::vector<T> scratch;
    std::vector<const T*> taps;
    std::vector<std::int32_t> packed;  // a row of red, green and blue in one number
    std::vector<char> holes;           // of each row: whether it has pixels that are not known
  };

  // Planes of `fixed_`: for each row of the image what does not change from frame to frame.
  static constexpr Index rest_plane = 0, inverse_ray_plane = 1, first_plane = 2;
  // Rows of a workspace's scratch.
  static constexpr Index depth_row = 0, bulge_row = 1, lack_row = 2, normal_rows = 3, rgb_rows = 8,
                         phong_rows = 11, scratch_rows = 14;

  template <class D>
  void check(const D& rest_depth, const std::vector<Light<T>>& lights,
             const Background<T>& background) const {
    camera_.require_valid();
    detail::require_camera_size(rest_depth, camera_, "the rest depth image");
    if (background.is_image()) {
      detail::require_camera_size(background.image(), camera_, "the background image");
    }
    detail::require(std::isfinite(options_.ambient), "ambient ", options_.ambient,
                    " is not finite");
    for (std::size_t k = 0; k < lights.size(); ++k) check_light(lights[k], k);
  }

  void check_light(const Light<T>& light, std::size_t k) const {
    const auto finite = [](T value) { return std::isfinite(value); };
    const auto& direction = light.direction;
    detail::require(direction.width() == camera_.width && direction.height() == camera_.height,
                    "the direction image of light ", k, " is ", direction.width(), " x ",
                    direction.height(), " pixels, the camera's image ", camera_.width, " x ",
                    camera_.height);
    detail::require(std::all_of(light.rgb.begin(), light.rgb.end(), finite) &&
                        finite(light.diffuse) && finite(light.specular),
                    "light ", k, " has a colour or coefficient that is not finite");
    detail::require(finite(light.shininess) && light.shininess >= 0, "light ", k, " has shininess ",
                    light.shininess, ", which is negative or not finite");
    detail::require(
        options_.specular == Specular::gated || light.shininess == std::floor(light.shininess),
        "light ", k, " has shininess ", light.shininess,
        ", which the unclamped specular term needs to be an integer");
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        const Vec3<T>& d = direction(x, y);
        detail::require(d.allFinite(), "light ", k, " has direction (", d.x(), ", ", d.y(), ", ",
                        d.z(), ") at pixel (", x, ", ", y, "), which is not finite");
      }
    }
  }

  template <class D>
  void keep_rest(const D& rest_depth) {
    for (Index y = 0; y < camera_.height; ++y) {
      T* const rest = fixed_.row(y, rest_plane);
      T* const inverse_ray = fixed_.row(y, inverse_ray_plane);
      for (Index x = 0; x < camera_.width; ++x) {
        const T z = static_cast<T>(ImageTraits<D>::pixel(rest_depth, x, y));
        rest[x] = detail::is_depth(z) ? z : std::numeric_limits<T>::quiet_NaN();
        inverse_ray[x] = 1 / camera_.ray(static_cast<T>(x), static_cast<T>(y)).norm();
      }
    }
  }

  // As shares of 255, so that a sum of them is ready to be truncated.
  void keep_background(const Background<T>& background) {
    const T scale = static_cast<T>(255 * options_.ambient);
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        const auto& rgb = background.is_image() ? background.image()(x, y) : background.solid();
        for (Index c = 0; c < 3; ++c) {
          fixed_.row(y, first_plane + c)[x] = scale * rgb[static_cast<std::size_t>(c)];
        }
      }
    }
  }

  void keep_lights(const std::vector<Light<T>>& lights) {
    Image<T> rest(camera_.width, camera_.height);
    for (Index y = 0; y < camera_.height; ++y) {
      std::copy_n(fixed_.row(y, rest_plane), camera_.width, rest.row(y));
    }
    const auto normals =
        sobel_normals(rest, camera_.template cast<double>(), options_.border_normals);
    for (std::size_t k = 0; k < lights.size(); ++k) {
      const Light<T>& light = lights[k];
      for (Index y = 0; y < camera_.height; ++y) {
        for (Index x = 0; x < camera_.width; ++x) {
          Vec3<double> to_light = -light.direction(x, y).template cast<double>();
          if (options_.rectify) {
            to_light -= to_light.dot(normals(x, y)) * normals(x, y);
            to_light.stableNormalize();
          }
          for (Index c = 0; c < 3; ++c) {
            fixed_.row(y, light_plane(k) + c)[x] = static_cast<T>(to_light[c]);
          }
        }
      }
      const T least = std::pow(std::numeric_limits<T>::min(), 1 / std::max(T(1), light.shininess));
      detail::LightColour<T> colour{{}, {}, light.shininess, options_.specular, least};
      for (std::size_t c = 0; c < 3; ++c) {
        colour.diffuse[c] = 255 * light.rgb[c] * light.diffuse;
        colour.specular[c] = 255 * light.rgb[c] * light.specular;
      }
      colours_.push_back(colour);
    }
  }

  [[nodiscard]] static Index light_plane(std::size_t k) {
    return first_plane + 3 + 3 * static_cast<Index>(k);
  }

  [[nodiscard]] std::unique_ptr<Workspace> make_workspace() const {
    auto work = std::make_unique<Workspace>();
    const auto width = static_cast<std::size_t>(camera_.width);
    const auto window = static_cast<std::size_t>(window_);
    work->padded.resize(width + 2 * static_cast<std::size_t>(radius_));
    work->protrusion.resize(width * window);
    work->missing.resize(width * window);
    work->membrane.resize((width + 2) * 3);
    work->scratch.resize(width * scratch_rows);
    work->taps.resize(window);
    work->packed.resize(width);
    work->holes.resize(static_cast<std::size_t>(camera_.height));
    return work;
  }

  [[nodiscard]] T* scratch(Workspace& work, Index row) const {
    return work.scratch.data() + std::ptrdiff_t{row} * camera_.width;
  }
  [[nodiscard]] T* smeared(std::vector<T>& rows, Index y) const {
    return rows.data() + std::ptrdiff_t{y % window_} * camera_.width;
  }
  [[nodiscard]] T* membrane(Workspace& work, Index y) const {
    return work.membrane.data() + std::ptrdiff_t{(y + 3) % 3} * (camera_.width + 2) + 1;
  }

  // Each row goes down the pipeline as soon as the rows that it needs are there.
  template <class D>
  void render_rows(ImageView<Rgb8> out, const D& depth) const {
    auto work = workspaces_.take([&] { return make_workspace(); });
    const Index last = camera_.height - 1;
    Index pressed = 0, bulged = 0;
    for (Index y = 0; y <= last; ++y) {
      for (; bulged <= std::min(last, y + 1); ++bulged) {
        for (; pressed <= std::min(last, bulged + radius_); ++pressed) {
          press(*work, depth, pressed);
        }
        bulge(*work, depth, bulged);
      }
      shade(*work, y);
      if (work->holes[static_cast<std::size_t>(y)] != 0) show_holes(*work, depth, y);
      write(out, *work, y);
    }
    workspaces_.give_back(std::move(work));
  }

  // The depth of whatever touches the membrane, and the membrane's own elsewhere.
  template <class D>
  void read_contact(const D& depth, Index y, T* __restrict contact, bool& holes) const {
    detail::read_row(depth, y, contact, camera_.width);
    const T* __restrict rest = fixed_.row(y, rest_plane);
    constexpr T most = std::numeric_limits<T>::max();
    const bool clip = options_.clip_to_rest;
    int unknown = 0;
    for (Index x = 0; x < camera_.width; ++x) {
      const T z = contact[x];
      const T deepest = clip ? rest[x] : most;
      const bool positive = z > 0, finite = z <= most, inside = rest[x] == rest[x];
      unknown |= !(positive & finite & inside);
      contact[x] = positive & (z <= deepest) ? z : rest[x];
    }
    holes = unknown != 0;
  }

  // The protrusion of row y, smoothed along the row.
  template <class D>
  void press(Workspace& work, const D& depth, Index y) const {
    const Index width = camera_.width;
    const T* const rest = fixed_.row(y, rest_plane);
    T* const contact = scratch(work, depth_row);
    bool holes = false;
    read_contact(depth, y, contact, holes);
    work.holes[static_cast<std::size_t>(y)] = holes;
    T* const row = work.padded.data() + radius_;
    for (Index x = 0; x < width; ++x) {
      const bool touches = (contact[x] < rest[x]) | (contact[x] > rest[x]);  // neither for NaN
      row[x] = touches ? rest[x] - contact[x] : 0;
    }
    smear(work, smeared(work.protrusion, y));
    if (!holes) return;
    detail::read_row(depth, y, row, width);
    for (Index x = 0; x < width; ++x) row[x] = is_known(row[x], rest[x]) ? 0 : 1;
    smear(work, smeared(work.missing, y));
  }

  [[nodiscard]] static bool is_known(T depth, T rest) {
    return detail::is_depth(depth) && detail::is_depth(rest);
  }

  void smear(Workspace& work, T* out) const {
    const Index width = camera_.width;
    T* const row = work.padded.data() + radius_;
    for (Index k = 1; k <= radius_; ++k) {
      row[-k] = row[detail::inside(-k, width, Border::reflect101)];
      row[width - 1 + k] = row[detail::inside(width - 1 + k, width, Border::reflect101)];
    }
    const T** const taps = work.taps.data() + radius_;
    for (Index k = -radius_; k <= radius_; ++k) taps[k] = row + k;
    detail::symmetric_sum(out, taps, weights_.data(), radius_, width);
  }

  // Row y of the membrane's depth, and the rows beyond the image's first and last.
  template <class D>
  void bulge(Workspace& work, const D& depth, Index y) const {
    const Index width = camera_.width;
    const T* const rest = fixed_.row(y, rest_plane);
    T* const contact = scratch(work, depth_row);
    T* const spread = scratch(work, bulge_row);
    bool holes = false;
    read_contact(depth, y, contact, holes);
    T* const z = membrane(work, y);
    if (radius_ == 0) {
      std::copy_n(contact, width, z);
    } else {
      spread_down(work, work.protrusion, y, spread, false);
      if (has_holes_near(work, y)) {
        T* const lack = scratch(work, lack_row);
        spread_down(work, work.missing, y, lack, true);
        for (Index x = 0; x < width; ++x) {
          const T known = 1 - lack[x];
          spread[x] = lack[x] == 0 ? spread[x] : known > 0 ? spread[x] / known : 0;
        }
      }
      for (Index x = 0; x < width; ++x) {
        const T bulged = rest[x] - spread[x];
        z[x] = contact[x] < bulged ? contact[x] : bulged;
      }
    }
    detail::extrapolate_ends(z, width);
    const Index last = camera_.height - 1;
    if (y == std::min(Index{1}, last)) {
      detail::extrapolate_row(membrane(work, -1), membrane(work, 0), membrane(work, y), width);
    }
  }

  [[nodiscard]] bool has_holes_near(const Workspace& work, Index y) const {
    const auto first = work.holes.begin() + std::max(Index{0}, y - radius_);
    const auto end = work.holes.begin() + std::min(camera_.height, y + radius_ + 1);
    return std::any_of(first, end, [](char holes) { return holes != 0; });
  }

  // Smooths along the columns; rows without holes count as zero where only holes are kept.
  void spread_down(Workspace& work, std::vector<T>& rows, Index y, T* out, bool only_holes) const {
    const T** const taps = work.taps.data() + radius_;
    for (Index k = -radius_; k <= radius_; ++k) {
      const Index from = detail::inside(y + k, camera_.height, Border::reflect101);
      const bool zero = only_holes && work.holes[static_cast<std::size_t>(from)] == 0;
      taps[k] = zero ? zeros_.data() : smeared(rows, from);
    }
    detail::symmetric_sum(out, taps, weights_.data(), radius_, camera_.width);
  }

  void shade(Workspace& work, Index y) const {
    const Index width = camera_.width, last = camera_.height - 1;
    if (y == last) {
      // Of the ring's three rows, the one of y - 2 is free. A single row stays flat.
      detail::extrapolate_row(membrane(work, y + 1), membrane(work, y),
                              membrane(work, std::max(Index{0}, y - 1)), width);
    }
    const detail::NormalRow<T> n{scratch(work, normal_rows), scratch(work, normal_rows + 1),
                                 scratch(work, normal_rows + 2), scratch(work, normal_rows + 3)};
    const T v = camera_.ray(0, static_cast<T>(y)).y();
    detail::sobel_normal_row(n, scratch(work, normal_rows + 4), membrane(work, y - 1),
                             membrane(work, y), membrane(work, y + 1),
                             {columns_.data(), v, camera_.fx, camera_.fy}, width);
    if (options_.border_normals == BorderNormals::none) {
      for (T* const plane : {n.x, n.y, n.z, n.facing}) {
        if (y == 0 || y == last) std::fill_n(plane, width, T(0));
        plane[0] = plane[width - 1] = 0;
      }
    }
    const detail::RgbRow<T> rgb{scratch(work, rgb_rows), scratch(work, rgb_rows + 1),
                                scratch(work, rgb_rows + 2)};
    std::copy_n(fixed_.row(y, first_plane), 3 * width, rgb.r);
    for (std::size_t k = 0; k < colours_.size(); ++k) {
      const Index plane = light_plane(k);
      detail::phong_row(
          rgb, n, {fixed_.row(y, plane), fixed_.row(y, plane + 1), fixed_.row(y, plane + 2)},
          colours_[k], {columns_.data(), fixed_.row(y, inverse_ray_plane), v},
          {scratch(work, phong_rows), scratch(work, phong_rows + 1), scratch(work, phong_rows + 2)},
          width);
    }
  }

  // Pixels whose depth is not known show the background.
  template <class D>
  void show_holes(Workspace& work, const D& depth, Index y) const {
    T* const row = scratch(work, depth_row);
    detail::read_row(depth, y, row, camera_.width);
    const T* const rest = fixed_.row(y, rest_plane);
    for (Index x = 0; x < camera_.width; ++x) {
      if (is_known(row[x], rest[x])) continue;
      for (Index c = 0; c < 3; ++c) {
        scratch(work, rgb_rows + c)[x] = fixed_.row(y, first_plane + c)[x];
      }
    }
  }

  void write(ImageView<Rgb8> out, Workspace& work, Index y) const {
    std::int32_t* const packed = work.packed.data();
    detail::pack_row(packed, scratch(work, rgb_rows), scratch(work, rgb_rows + 1),
                     scratch(work, rgb_rows + 2), camera_.width);
    for (Index x = 0; x < camera_.width; ++x) {
      const auto rgb = static_cast<std::uint32_t>(packed[x]);
      out(x, y) = {static_cast<std::uint8_t>(rgb), static_cast<std::uint8_t>(rgb >> 8),
                   static_cast<std::uint8_t>(rgb >> 16)};
    }
  }

  Camera<T> camera_;
  TactileOptions options_;
  Index radius_, window_;
  std::vector<T> weights_, zeros_, columns_;
  detail::RowPlanes<T> fixed_;
  std::vector<detail::LightColour<T>> colours_;
  Image<Rgb8> rest_image_;
  mutable detail::Store<Workspace> workspaces_;
};

template <std::floating_point T, class... Rest>
TactileRenderer(const Camera<T>&, const Rest&...) -> TactileRenderer<T>;

}  // namespace gelight
