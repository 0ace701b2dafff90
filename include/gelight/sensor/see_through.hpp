#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/plane_fit.hpp"
#include "gelight/image/plane_fit_rows.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/frame/light_check.hpp"
#include "gelight/sensor/frame/output.hpp"
#include "gelight/sensor/frame/store.hpp"
#include "gelight/sensor/rows/lit_rows.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// How bright it is on the two sides of a half-silvered membrane, as shares of full light.
struct LightLevels {
  double inner = 0.5;  ///< the LEDs
  double outer = 0.5;  ///< what lies beyond the membrane

  /// LEDs on, dark outside: a tactile sensor.
  [[nodiscard]] static LightLevels tactile() { return {1, 0}; }
  /// LEDs off: a camera that looks through the membrane.
  [[nodiscard]] static LightLevels visual() { return {0, 1}; }
  /// The default, both at once: at half of their light, so that their sum is not too bright for the
  /// camera.
  [[nodiscard]] static LightLevels visuotactile() { return {0.5, 0.5}; }
};

/// How a SeeThroughRenderer turns a depth map into an image. The defaults of thickness and ambient
/// light are the paper's.
struct SeeThroughOptions {
  /// How far the gel can be pressed in, in the unit of the depth.
  double thickness = 0.005;
  /// Normals are fitted to (2 radius + 1)^2 neighbours.
  Index normal_radius = 2;
  /// The ambient term of Phong's equation.
  double ambient = 0.8;
  /// The share of its light that gel loses which is pressed in by `darkening_depth` (in the unit of
  /// the depth) or more; less where it is pressed less.
  double darkening = 0.2;
  double darkening_depth = 0.002;  ///< see darkening
  /// The shares of light that the membrane's coating throws back and lets through; what is missing
  /// to 1 it swallows.
  double reflectance = 0.5, transmittance = 0.5;  ///< their sum is at most 1
  /// The camera's gain: with 2, half of the light gives a full image.
  double exposure = 2;
  /// The light of those calls of `render` that do not tell.
  LightLevels levels = {};
};

/// Four lights at the image's edges, each shining straight across the gel and `tilt` (radians)
/// towards it: red from the right, green from the left, blue from below, white from above, with the
/// coefficients of the STS paper: diffuse 1, specular 0.5, shininess 5. By the defaults of the
/// renderer and LightLevels::tactile() a flat gel before the camera is as bright as images get from
/// a tilt of some 0.2 on; 0.1 leaves room for contacts. Throws InvalidInput for a camera that is
/// not valid and a tilt outside [0, pi/2].
template <std::floating_point T>
[[nodiscard]] std::vector<Light<T>> edge_lights(const Camera<T>& camera, double tilt) {
  camera.require_valid();
  detail::require(tilt >= 0 && tilt <= std::numbers::pi / 2, "a tilt of ", tilt,
                  " radians is not in [0, pi/2]");
  const auto along = static_cast<T>(std::cos(tilt)), in = static_cast<T>(std::sin(tilt));
  std::vector<Light<T>> lights;
  const auto add = [&](T x, T y, const std::array<T, 3>& rgb) {
    lights.push_back({Image<Vec3<T>>(camera.width, camera.height, {along * x, along * y, in}), rgb,
                      T(1), T(0.5), T(5)});
  };
  add(-1, 0, {1, 0, 0});
  add(1, 0, {0, 1, 0});
  add(0, -1, {0, 0, 1});
  add(0, 1, {1, 1, 1});
  return lights;
}

/// Renders the image of a camera behind a half-silvered membrane: a tactile sensor where it is lit
/// inside, a camera where it is bright outside (See-Through-your-Skin, STS).
///
/// For every frame: the depth is clipped to the gel's thickness; the normals are the directions of
/// least covariance of each point's neighbours; Phong's equation adds up the lights; gel that is
/// pressed in loses a share. That light the coating reflects in the membrane's colours
/// (`background`), and lets through what is beyond:
///     exposure (reflectance inner background Phong + transmittance outer visual),
/// in linear light, clamped to [0, 1] and truncated to 8 bits. So tactile, visual and visuotactile
/// image are one model, and pass over into one another as LightLevels change. What LEDs light up
/// beyond the membrane is left out: their light passes the coating twice. (Hogan, Jenkin,
/// Rezaei-Shoshtari, Girdhar, Meger, Dudek, Seeing Through your Skin, 2021,
/// doi:10.1109/WACV48630.2021.00126)
///
/// Depths mean what image/mask.hpp says: a pixel whose depth is not known is lit by ambient light
/// alone, and its neighbours' normals are fitted without it (as plane_fit_normals does: where what
/// is left of a window lies on a line of the image, ambient light alone); one without a rest depth
/// lies outside the membrane.
///
/// What does not depend on the frame is computed once, and normals only around what touches.
/// `render` may be called from several threads.
template <std::floating_point T>
class SeeThroughRenderer {
 public:
  /// Throws InvalidInput for a camera that is not valid, an image of another size than the
  /// camera's, a light with a number that is not finite, options out of range, a coating that would
  /// give more light than it gets, and a rest depth that plane_fit_normals does not take.
  template <ImageOf<T> D>
  SeeThroughRenderer(const Camera<T>& camera, const D& rest_depth,
                     const std::vector<Light<T>>& lights,
                     const Background<T>& background = std::array<T, 3>{T(0.7), T(0.7), T(0.8)},
                     const SeeThroughOptions& options = {})
      : camera_(camera),
        options_(checked(options, camera, rest_depth, lights, background)),
        rest_(camera.width, camera.height),
        planes_(camera, options.normal_radius),
        lights_(camera, static_cast<T>(options.ambient), lights,
                detail::fit_rounding(camera, options.normal_radius)),
        colour_(3 * pixel_count()),
        rest_light_(3 * pixel_count()),
        rest_image_(camera.width, camera.height) {
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        const T z = static_cast<T>(ImageTraits<D>::pixel(rest_depth, x, y));
        rest_(x, y) = detail::is_depth(z) ? z : unknown;
      }
    }
    keep_colour(background);
    light_rest();
    render_into(rest_image_, rest_);
  }

  /// What the renderer was made with.
  ///@{
  [[nodiscard]] const Camera<T>& camera() const { return camera_; }
  [[nodiscard]] const SeeThroughOptions& options() const { return options_; }
  ///@}

  /// The image of the membrane that nothing touches, in the options' light, with nothing beyond.
  [[nodiscard]] const Image<Rgb8>& rest_image() const { return rest_image_; }

  /// The image of a depth map of what touches the membrane, in the unit of the rest depth, in the
  /// options' light, with nothing to be seen beyond. Throws InvalidInput for an image of another
  /// size than the camera's.
  template <ImageOf<T> D>
  [[nodiscard]] Image<Rgb8> render(const D& depth) const {
    Image<Rgb8> out(camera_.width, camera_.height);
    render_into(out, depth);
    return out;
  }

  /// The same with what a camera would see without the membrane (`visual`: grey or RGB, of numbers
  /// as a Background's). Throws InvalidInput also where one that is seen is not from 0 to 1.
  template <ImageOf<T> D, detail::ColourImage V>
  [[nodiscard]] Image<Rgb8> render(const D& depth, const V& visual) const {
    return render(depth, visual, options_.levels);
  }

  /// The same in other light. Throws InvalidInput for levels that are negative or not finite, too.
  template <ImageOf<T> D, detail::ColourImage V>
  [[nodiscard]] Image<Rgb8> render(const D& depth, const V& visual,
                                   const LightLevels& levels) const {
    Image<Rgb8> out(camera_.width, camera_.height);
    render_into(out, depth, visual, levels);
    return out;
  }

  /// The same into the caller's pixels. Throws InvalidInput, before anything is written, also for
  /// an output of another size or in the memory of the depth or the visual image.
  ///@{
  template <ImageOf<T> D>
  void render_into(ImageView<Rgb8> out, const D& depth) const {
    render_checked(out, depth, Dark{}, options_.levels);
  }

  template <ImageOf<T> D, detail::ColourImage V>
  void render_into(ImageView<Rgb8> out, const D& depth, const V& visual) const {
    render_into(out, depth, visual, options_.levels);
  }

  template <ImageOf<T> D, detail::ColourImage V>
  void render_into(ImageView<Rgb8> out, const D& depth, const V& visual,
                   const LightLevels& levels) const {
    detail::require_camera_size(visual, camera_, "the visual image");
    detail::require_apart(out, visual, "the visual image");
    require_level(levels.inner, "inner", options_);
    require_level(levels.outer, "outer", options_);
    if constexpr (!detail::has_levels<ImagePixel<V>>()) {
      if (light_through(levels) > 0) require_colours(visual);
    }
    render_checked(out, depth, visual, levels);
  }
  ///@}

 private:
  static constexpr T unknown = std::numeric_limits<T>::quiet_NaN();

  /// Nothing to be seen beyond the membrane.
  struct Dark {};

  /// Columns and rows from left and top to before right and bottom.
  struct Box {
    Index left = 0, top = 0, right = 0, bottom = 0;
    [[nodiscard]] bool is_empty() const { return left >= right || top >= bottom; }
    /// With as many pixels more on every side as there are.
    [[nodiscard]] Box grown(Index by, Index width, Index height) const {
      return {std::max(Index{0}, left - by), std::max(Index{0}, top - by),
              std::min(width, right + by), std::min(height, bottom + by)};
    }
  };

  struct Workspace {
    Image<T> gel;  // the depth of the gel's surface
    Box changed;   // where its normals may not be those at rest
    detail::PlaneFitRows<T> planes;
    typename detail::LitRows<T>::Workspace lights;
    std::array<std::vector<T>, 4> normals;    // x, y, z, and the product with the rays: a row each
    std::array<std::vector<T>, 3> lit, seen;  // red, green, blue: a row each
    std::vector<T> kept;                      // the share of light that is left
    std::vector<std::int32_t> packed;
  };

  template <class D>
  [[nodiscard]] static const SeeThroughOptions& checked(const SeeThroughOptions& options,
                                                        const Camera<T>& camera,
                                                        const D& rest_depth,
                                                        const std::vector<Light<T>>& lights,
                                                        const Background<T>& background) {
    camera.require_valid();
    detail::require_camera_size(rest_depth, camera, "the rest depth image");
    const double most = detail::most_fitted(camera);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        detail::require_fitted_depth(static_cast<T>(ImageTraits<D>::pixel(rest_depth, x, y)), x, y,
                                     most);
      }
    }
    if (background.is_image()) {
      detail::require_camera_size(background.image(), camera, "the background image");
    }
    require_valid(options);
    detail::require_lights(lights, camera, Specular::gated);
    return options;
  }

  static void require_valid(const SeeThroughOptions& options);
  static void require_level(double level, const char* side, const SeeThroughOptions& options);

  template <class V>
  void require_colours(const V& visual) const {
    if (detail::vectorised([&] { return detail::are_shares_of_light(visual); })) return;
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        detail::require_colour(detail::linear_rgb<T>(ImageTraits<V>::pixel(visual, x, y)),
                               "the visual image at pixel (", x, ", ", y, ")");
      }
    }
  }

  // What of the light beyond the membrane the camera sees, in grey levels.
  [[nodiscard]] T light_through(const LightLevels& levels) const {
    return static_cast<T>(255 * options_.exposure * options_.transmittance * levels.outer);
  }

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  }

  [[nodiscard]] Workspace make_workspace() const;

  template <class D, class V>
  void render_checked(ImageView<Rgb8> out, const D& depth, const V& visual,
                      const LightLevels& levels) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    detail::require_camera_size(out, camera_, "the output image");
    detail::require_apart(out, depth, "the depth image");
    workspaces_.lend([this] { return make_workspace(); },
                     [&](Workspace& work) {
                       press(work, depth);
                       render_rows(out, visual, levels, work);
                     });
  }

  // Clips the depth to the gel; tells where that changes its normals.
  template <class D>
  void press(Workspace& work, const D& depth) const {
    const T thickness = static_cast<T>(options_.thickness);
    Box touched{camera_.width, camera_.height, 0, 0};
    for (Index y = 0; y < camera_.height; ++y) {
      T* const gel = work.gel.row(y);
      const T* const rest = rest_.row(y);
      for (Index x = 0; x < camera_.width; ++x) {
        const T z = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
        const T clipped = std::min(std::max(z, rest[x] - thickness), rest[x]);
        gel[x] = detail::is_known(z) && rest[x] > 0 ? clipped : unknown;
      }
      const auto bytes = static_cast<std::size_t>(camera_.width) * sizeof(T);
      if (std::memcmp(gel, rest, bytes) == 0) continue;
      const auto differs = [&](Index x) { return !(gel[x] >= rest[x]) && rest[x] > 0; };
      Index first = 0, last = camera_.width;
      while (first < last && !differs(first)) ++first;
      while (last > first && !differs(last - 1)) --last;
      if (first == last) continue;
      touched.left = std::min(touched.left, first);
      touched.right = std::max(touched.right, last);
      touched.top = std::min(touched.top, y);
      touched.bottom = y + 1;
    }
    work.changed =
        touched.is_empty() ? Box{} : touched.grown(reach(), camera_.width, camera_.height);
  }

  // The membrane's colours, as shares of 255 of what the camera sees of them in full light.
  void keep_colour(const Background<T>& background);
  // What the membrane throws back at rest.
  void light_rest();

  [[nodiscard]] std::ptrdiff_t offset(Index y, std::size_t c) const {
    return (static_cast<std::ptrdiff_t>(c) * camera_.height + y) * camera_.width;
  }

  // Fitted windows move down from the first row that those of the box's first row see.
  [[nodiscard]] Index first_seen(const Box& box) const {
    return std::max(Index{0}, box.top - reach());
  }
  [[nodiscard]] Index reach() const { return planes_.radius(); }

  void start_fit(Workspace& work) const;
  // The light that the membrane throws back in the changed columns of a row, the next one.
  void light_row(Workspace& work, Index y) const;
  // The same, in the registers that light_row has chosen.
  void fit_and_light(Workspace& work, Index y) const;
  static void clear_unknown(T* __restrict row, const T* depth, std::ptrdiff_t count);
  static void scale_row(T* __restrict row, const T* scale, std::ptrdiff_t count);

  template <class V>
  void render_rows(ImageView<Rgb8> out, const V& visual, const LightLevels& levels,
                   Workspace& work) const {
    const T inner = static_cast<T>(levels.inner);
    const T through = light_through(levels);
    for (Index y = 0; y < camera_.height; ++y) {
      detail::vectorised([&] { see_row(work, visual, y, through); });
      write_row(out, work, y, inner);
    }
  }

  // Adds to what comes through a row what the membrane throws back of the light inside.
  void write_row(ImageView<Rgb8> out, Workspace& work, Index y, T inner) const;

  // What comes through the membrane.
  template <class V>
  void see_row(Workspace& work, const V& visual, Index y, T through) const {
    T *const r = work.seen[0].data(), *const g = work.seen[1].data(),
             *const b = work.seen[2].data();
    if constexpr (ImageLike<V>) {
      if (through > 0) {
        for (Index x = 0; x < camera_.width; ++x) {
          const auto rgb = detail::linear_rgb<T>(ImageTraits<V>::pixel(visual, x, y));
          r[x] = through * rgb[0];
          g[x] = through * rgb[1];
          b[x] = through * rgb[2];
        }
        return;
      }
    }
    for (T* const row : {r, g, b}) std::fill_n(row, camera_.width, T(0));
  }

  Camera<T> camera_;
  SeeThroughOptions options_;
  Image<T> rest_;  // NaN where it is not known
  detail::PlaneFitRows<T> planes_;
  detail::LitRows<T> lights_;
  detail::Array<T> colour_, rest_light_;  // three planes each
  Image<Rgb8> rest_image_;
  mutable detail::Store<Workspace> workspaces_;
};

template <std::floating_point T, class... Rest>
SeeThroughRenderer(const Camera<T>&, const Rest&...) -> SeeThroughRenderer<T>;

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/sensor/see_through/body.hpp"
#endif
