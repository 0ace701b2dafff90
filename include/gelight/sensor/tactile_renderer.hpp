#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/concepts/membrane.hpp"
#include "gelight/concepts/reflectance.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/frame/changed_blocks.hpp"
#include "gelight/sensor/frame/light_check.hpp"
#include "gelight/sensor/frame/output.hpp"
#include "gelight/sensor/frame/store.hpp"
#include "gelight/sensor/phong_lights.hpp"
#include "gelight/sensor/rows/membrane_rows.hpp"
#include "gelight/sensor/rows/model_rows.hpp"
#include "gelight/sensor/rows/model_shading.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/sensor/rows/shaded_rows.hpp"
#include "gelight/sensor/rows/surface_range.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

namespace detail {

template <std::floating_point T, class Membrane>
struct ChosenRows {
  using Type = ModelRows<T, Membrane>;
};
template <std::floating_point T>
struct ChosenRows<T, GaussianMembrane<T>> {
  using Type = MembraneRows<T>;
};

template <std::floating_point T, class Shine>
struct ChosenShading {
  using Type = ModelShading<T, Shine>;
};
template <std::floating_point T>
struct ChosenShading<T, PhongLights<T>> {
  using Type = ShadedRows<T>;
};

}  // namespace detail

/// How a TactileRenderer turns a depth map into an image.
struct TactileOptions {
  /// Standard deviation, in pixels, of the Gaussian that spreads a protrusion over the membrane;
  /// 0 is a membrane that follows the object exactly.
  double smoothing_sigma = 5;
  /// Where that Gaussian is cut off, in pixels.
  Index smoothing_radius = 20;
  /// Make the lights' directions tangent to the membrane at rest, and of unit length. At rest it is
  /// then without any light, but for the unclamped specular term.
  bool rectify = false;
  /// Rectified directions keep their lengths, which are the strength of the light.
  bool keep_strength = false;
  /// Take what lies deeper than the membrane at rest as not touching it, rather than as pulling it.
  bool clip_to_rest = true;
  /// The share of the background that is seen without any light.
  double ambient = 0.5;
  /// The form of Phong's specular term.
  Specular specular = Specular::gated;
  /// The share of the ambient light that gel loses which is pressed in by `darkening_depth` (in the
  /// unit of the depth) or more; less where it is pressed less.
  double darkening = 0;
  double darkening_depth = 0.03;  ///< where the darkening is full, in the unit of the depth
  /// The published images have no normals on the outermost pixels: these show ambient light alone,
  /// and what `Specular::unclamped` makes of no normal.
  BorderNormals border_normals = BorderNormals::none;
  /// Compute only what the contact can have changed, and take the rest from `rest_image()`. The
  /// image is the same; without it every frame takes as long as the largest contact.
  bool skip_unchanged = true;

  /// The options with which the GelTip authors' published images come out: for all their light
  /// fields but the linear one `rectify` is true.
  [[nodiscard]] static TactileOptions as_published(bool rectify) {
    TactileOptions options;
    options.rectify = rectify;
    options.clip_to_rest = false;
    options.specular = Specular::unclamped;
    return options;
  }

  /// More pixels than any image is wide: a larger sigma in `for_gel` is one of another unit.
  static constexpr double widest_sigma = 1e4;

  /// The options with the Gaussian that is nearest to a gel, for contacts of a radius, on pixels of
  /// a width, both in m: as `gaussian_sigma` tells, cut off at 4 sigma. Throws InvalidInput as that
  /// does, for a width that is not positive and finite, and for a sigma beyond `widest_sigma`.
  [[nodiscard]] static TactileOptions for_gel(const Gel& gel, double contact_radius, double pixel) {
    detail::require(pixel > 0 && std::isfinite(pixel), "a pixel's width ", pixel,
                    " is not positive and finite");
    TactileOptions options;
    options.smoothing_sigma = gaussian_sigma(gel, contact_radius) / pixel;
    detail::require(options.smoothing_sigma <= widest_sigma, "contacts of ", contact_radius,
                    " m on pixels of ", pixel, " m take a Gaussian of ", options.smoothing_sigma,
                    " pixels, more than ", widest_sigma);
    options.smoothing_radius = static_cast<Index>(std::ceil(4 * options.smoothing_sigma));
    return options;
  }
};

/// How a TactileRenderer of any membrane and reflectance turns a depth map into an image: those of
/// TactileOptions that do not belong to either.
struct FrameOptions {
  double darkening = 0;                                ///< see TactileOptions
  double darkening_depth = 0.03;                       ///< see TactileOptions
  BorderNormals border_normals = BorderNormals::none;  ///< see TactileOptions
  bool skip_unchanged = true;                          ///< see TactileOptions
};

/// A depth map of what touches the membrane, and the image that a TactileRenderer made of it.
template <std::floating_point T>
struct TactileFrame {
  Image<T> depth;     ///< in the unit of the renderer's rest depth
  Image<Rgb8> image;  ///< of the camera's size, like the depth
};

/// Renders the image that the camera inside an optical tactile sensor takes of its lit membrane.
///
/// For every frame: the membrane is pressed in by whatever is nearer than its rest depth, and
/// bulges around it by a Gaussian of the protrusion, min(depth, rest - G(rest - depth)); its
/// points' Sobel derivatives give the normals; Phong's equation adds up the lights over a share of
/// the background; the sum is clamped to [0, 1] and truncated to 8 bits. (Gomes, Paoletti, Luo
/// 2023, doi:10.15607/RSS.2023.XIX.035)
///
/// Depths mean what image/mask.hpp says. Where nothing is there, nothing touches. Where a depth is
/// not known, the pixel shows ambient light alone, and the protrusion around it is averaged over
/// the known pixels only, so that it does not spread; the membrane's neighbouring normals take it
/// to be where the average puts it. Where the rest depth is none, the pixel lies outside the
/// membrane: it and the normals beside it are without light. The membrane comes no nearer to the
/// camera than a 128th of its rest depth, and what lies beyond the range of depths that it takes
/// for a rest depth does not pull it. A frame that equals the rest depth (or
/// has nothing nearer) gives `rest_image()` bit for bit.
///
/// That is the membrane and the reflectance that it has by default. Others plug in: a membrane
/// model (concepts/membrane.hpp) tells what depth the membrane's surface takes, a reflectance
/// (concepts/reflectance.hpp) its colours.
///
/// Everything that does not depend on the frame is computed once. `render` may be called from
/// several threads; each borrows a workspace, so that after its first frame none allocates.
template <std::floating_point T, MembraneModel<T> Membrane = GaussianMembrane<T>,
          class Shine = PhongLights<T>>
requires(Reflectance<Shine, T> || std::same_as<Shine, PhongLights<T>>) class TactileRenderer {
  static constexpr bool is_gaussian = std::same_as<Membrane, GaussianMembrane<T>>;
  static constexpr bool is_phong = std::same_as<Shine, PhongLights<T>>;

 public:
  /// Throws InvalidInput for a camera that is not valid, an image that has another size than the
  /// camera's, a light or background with a number that is not finite, an ambient share or a
  /// light's coefficient of which T does not hold 512 times as much, a light beyond full light or
  /// with a direction longer than 1 (unless `rectify` makes it so), options out of range, an
  /// unclamped specular term with a shininess that is not an integer, and a rest depth of which the
  /// fourth power, times squares of focal lengths, leaves the range of T: in float and with focal
  /// lengths up to 1000 pixels it is to be from 1e-8 to 5e6.
  template <ImageOf<T> D>
  requires(is_gaussian&& is_phong)
      TactileRenderer(const Camera<T>& camera, const D& rest_depth,
                      const std::vector<Light<T>>& lights, const Background<T>& background = {},
                      const TactileOptions& options = {})
      : TactileRenderer(camera, rest_depth,
                        GaussianMembrane<T>(options.smoothing_sigma, options.smoothing_radius,
                                            options.clip_to_rest),
                        PhongLights<T>{lights, background, options.ambient, options.specular,
                                       options.rectify, options.keep_strength},
                        FrameOptions{options.darkening, options.darkening_depth,
                                     options.border_normals, options.skip_unchanged}) {}

  /// One of any membrane and any reflectance. Throws as the other does, and as the reflectance does
  /// that does not fit the camera.
  template <ImageOf<T> D>
  TactileRenderer(const Camera<T>& camera, const D& rest_depth, Membrane membrane, Shine shine,
                  const FrameOptions& options = {})
      : TactileRenderer(Direct(), camera, as_view(rest_depth), std::move(membrane),
                        std::move(shine), options) {}

  /// The camera that it was built with.
  [[nodiscard]] const Camera<T>& camera() const { return camera_; }
  /// The options that it was built with.
  [[nodiscard]] const FrameOptions& options() const { return options_; }

  /// The image of the membrane that nothing touches.
  [[nodiscard]] const Image<Rgb8>& rest_image() const { return rest_image_; }

  /// The image of a depth map of what touches the membrane, in the unit of the rest depth: that of
  /// an object as `rasterize` sees it, or of whatever else image/mask.hpp calls a depth.
  /// Throws InvalidInput for a depth image of another size than the camera's.
  template <ImageOf<T> D>
  [[nodiscard]] Image<Rgb8> render(const D& depth) const {
    Image<Rgb8> out(camera_.width, camera_.height);
    render_into(out, depth);
    return out;
  }

  /// The same, into the caller's pixels. Throws InvalidInput, before anything is written, for a
  /// depth or output image of another size than the camera's, and for an output that lies in the
  /// memory of the depth.
  template <ImageOf<T> D>
  void render_into(ImageView<Rgb8> out, const D& depth) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    detail::require_camera_size(out, camera_, "the output image");
    detail::require_apart(out, depth, "the depth image");
    render_all(out, depth, options_.skip_unchanged ? Extent::not_at_rest : Extent::everything);
  }

  /// The frame of the membrane that nothing touches, to begin a sequence with.
  [[nodiscard]] TactileFrame<T> rest_frame() const {
    TactileFrame<T> frame{Image<T>(camera_.width, camera_.height), rest_image_};
    for (Index y = 0; y < camera_.height; ++y) {
      std::copy_n(membrane_.rest(y), camera_.width, frame.depth.row(y));
    }
    return frame;
  }

  /// Makes a frame of this renderer the next one of a sequence, that of `depth`: computes only what
  /// differs from before. Its image is what `render(depth)` gives, bit for bit. Throws
  /// InvalidInput, before anything is written, for a frame or depth image of another size than the
  /// camera's, and for a depth image in the memory of the frame. Where the membrane, the
  /// reflectance or the depth image throws, the frame becomes `rest_frame()`.
  template <ImageOf<T> D>
  void render_next_into(TactileFrame<T>& frame, const D& depth) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    detail::require_camera_size(frame.depth, camera_, "the frame's depth image");
    detail::require_camera_size(frame.image, camera_, "the frame's image");
    detail::require_apart(ImageView<Rgb8>(frame.image), depth, "the depth image");
    detail::require_apart(ImageView<T>(frame.depth), depth, "the depth image");
    if constexpr (std::convertible_to<const D&, View>) {
      render_next_view(frame, depth);
    } else {
      render_next(frame, depth);
    }
  }

 private:
  // Images that views can look at are compiled for once; others are copied, or have their own.
  struct Direct {};
  using View = ImageView<const T>;
  TactileRenderer(Direct, const Camera<T>& camera, const View& rest_depth, Membrane membrane,
                  Shine shine, const FrameOptions& options);

  template <class D>
  [[nodiscard]] static auto as_view(const D& depth) {
    if constexpr (std::convertible_to<const D&, View>) {
      return View(depth);
    } else {
      const auto width = static_cast<Index>(ImageTraits<D>::width(depth));
      const auto height = static_cast<Index>(ImageTraits<D>::height(depth));
      Image<T> copy(width, height);
      for (Index y = 0; y < height; ++y) {
        for (Index x = 0; x < width; ++x) {
          copy(x, y) = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
        }
      }
      return copy;
    }
  }

  // What comes most often has loops of its own.
  using MembraneRows = typename detail::ChosenRows<T, Membrane>::Type;
  using ShadedRows = typename detail::ChosenShading<T, Shine>::Type;
  static constexpr bool reads_touched = detail::reads_touched<Shine>();

  /// What is computed of a frame; the rest of it is at rest, or as it was.
  enum class Extent : std::uint8_t { everything, not_at_rest, changed };

  struct Workspace {
    typename ShadedRows::Workspace shading;
    detail::Array<T> kept;        // of each pixel of a row: the share of ambient light that is left
    detail::Array<T> touched;     // of each pixel of a row: 1 where the object and the surface meet
    detail::Array<char> changed;  // of each block of a row
    detail::Array<detail::Run> runs;
    detail::ChangedBlocks changes;
    typename MembraneRows::Workspace membrane;  // last, since some are aligned to a cache line
  };

  template <class D>
  [[nodiscard]] static const FrameOptions& checked(const FrameOptions& options,
                                                   const Camera<T>& camera, const D& rest_depth) {
    camera.require_valid();
    detail::require_camera_size(rest_depth, camera, "the rest depth image");
    require_depth_range(rest_depth, camera);
    detail::require(options.darkening >= 0 && options.darkening <= 1, "darkening ",
                    options.darkening, " is not in [0, 1]");
    detail::require(options.darkening_depth > 0, "darkening depth ", options.darkening_depth,
                    " is not positive");
    detail::require(static_cast<T>(options.darkening_depth) >= std::numeric_limits<T>::min(),
                    "darkening depth ", options.darkening_depth, " is too small to divide by");
    return options;
  }

  template <class D>
  static void require_depth_range(const D& rest_depth, const Camera<T>& camera) {
    const detail::DepthRange<T> range(camera);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        const T z = static_cast<T>(ImageTraits<D>::pixel(rest_depth, x, y));
        const bool is_in_range = z >= range.least && z <= range.most;
        detail::require(!detail::is_depth(z) || is_in_range, "the rest depth ", z, " at pixel (", x,
                        ", ", y, ") is not between ", range.least, " and ", range.most);
      }
    }
  }

  template <class D>
  [[nodiscard]] static MembraneRows membrane_rows(Membrane membrane, const D& rest_depth,
                                                  const Camera<T>& camera) {
    const T deepest = detail::DepthRange<T>(camera).most;
    if constexpr (is_gaussian) {
      return {rest_depth, camera.width, camera.height, membrane.weights(),
              membrane.clips_to_rest() ? T(0) : deepest};
    } else {
      if constexpr (requires { membrane.require_fits(camera); }) membrane.require_fits(camera);
      return {std::move(membrane), rest_depth, camera.width, camera.height, deepest};
    }
  }

  template <class D>
  [[nodiscard]] static ShadedRows shaded_rows(const Camera<T>& camera, const D& rest_depth,
                                              Shine shine, const FrameOptions& options) {
    if constexpr (is_phong) {
      return phong_rows(camera, rest_depth, shine, options);
    } else {
      return {camera, std::move(shine)};
    }
  }

  template <class D>
  [[nodiscard]] static ShadedRows phong_rows(const Camera<T>& camera, const D& rest_depth,
                                             const PhongLights<T>& phong,
                                             const FrameOptions& options) {
    if (phong.background.is_image()) {
      detail::require_camera_size(phong.background.image(), camera, "the background image");
    }
    detail::require(std::isfinite(phong.ambient), "ambient ", phong.ambient, " is not finite");
    detail::require(std::abs(phong.ambient) <= detail::most_light<T>, "ambient ", phong.ambient,
                    " is more than the images' type can hold");
    detail::require_lights(phong.lights, camera, phong.specular,
                           phong.rectify && !phong.keep_strength);
    Image<Vec3<double>> normals;
    if (phong.rectify) {
      // Of the depths as they are rendered, rounded to T.
      Image<T> rest(camera.width, camera.height);
      for (Index y = 0; y < camera.height; ++y) {
        for (Index x = 0; x < camera.width; ++x) {
          rest(x, y) = static_cast<T>(ImageTraits<D>::pixel(rest_depth, x, y));
        }
      }
      normals = sobel_normals(rest, camera.template cast<double>(), options.border_normals);
    }
    return {camera,
            phong.background,
            phong.ambient,
            phong.lights,
            phong.specular,
            phong.rectify ? &normals : nullptr,
            phong.keep_strength};
  }

  [[nodiscard]] Workspace make_workspace() const {
    const auto blocks = static_cast<std::size_t>(detail::block_count(camera_.width));
    // A depth moves the membrane within its radius, which turns normals a pixel further.
    const Index reach = membrane_.radius() + 1;
    Workspace work{shading_.make_workspace(),
                   {},
                   {},
                   {},
                   {},
                   detail::ChangedBlocks(camera_.width, camera_.height, reach),
                   membrane_.make_workspace()};
    work.kept.resize(static_cast<std::size_t>(detail::whole_blocks(camera_.width)));
    if (reads_touched) work.touched.resize(static_cast<std::size_t>(camera_.width));
    work.changed.resize(blocks);
    work.runs.reserve(blocks);
    return work;
  }

  template <class Work>
  void lend_workspace(const Work& use) const {
    workspaces_.lend([this] { return make_workspace(); }, use);
  }

  template <class D>
  void render_all(ImageView<Rgb8> out, const D& depth, Extent extent) const {
    if constexpr (std::convertible_to<const D&, View>) {
      render_view(out, depth, extent);
    } else {
      lend_workspace([&](Workspace& work) { render_rows(out, depth, extent, work); });
    }
  }

  void render_view(ImageView<Rgb8> out, const View& depth, Extent extent) const;

  template <class D>
  void render_next(TactileFrame<T>& frame, const D& depth) const {
    lend_workspace([&](Workspace& work) {
      try {
        if (!work.changes.update(frame.depth, depth, work.membrane.buffer.data())) return;
        render_rows(frame.image, View(frame.depth), Extent::changed, work);
      } catch (...) {
        // Its depth is the next one's, or some of it, its image is not.
        frame = rest_frame();
        throw;
      }
    });
  }

  void render_next_view(TactileFrame<T>& frame, const View& depth) const;

  template <class D>
  void render_rows(ImageView<Rgb8> out, const D& depth, Extent extent, Workspace& work) const {
    if constexpr (is_gaussian) {
      stream_rows(out, depth, extent, work);
    } else {
      membrane_.press(work.membrane, depth, extent == Extent::everything,
                      wanted_surface(extent, work));
      for (Index y = 0; y < camera_.height; ++y) render_row(out, depth, extent, work, y);
    }
  }

  // Where the surface is needed for what is shaded, in whole blocks.
  [[nodiscard]] Window wanted_surface(Extent extent, const Workspace& work) const {
    if (extent == Extent::changed) return work.changes.window();
    return {0, 0, camera_.width, camera_.height};
  }

  // Every row goes down the pipeline as soon as the rows that it needs are there, so that all is
  // still in cache: press (smooth along) -> bulge (smooth down) -> normals -> shade -> out.
  template <class D>
  void stream_rows(ImageView<Rgb8> out, const D& depth, Extent extent, Workspace& work) const {
    constexpr Index band = MembraneRows::band;
    const Index height = camera_.height;
    Index pressed = 0, shaded = 0;
    membrane_.start(work.membrane, extent == Extent::everything);
    for (Index bulged = 0; bulged < height; bulged += band) {
      const Index needed = std::min(height, bulged + band + membrane_.radius());
      for (; pressed < needed; ++pressed) press_row(depth, extent, work, pressed);
      bulge_band(depth, extent, work, bulged);
      const Index ready = bulged + band < height ? bulged + band - 1 : height;
      for (; shaded < ready; ++shaded) render_row(out, depth, extent, work, shaded);
    }
  }

  template <class D>
  void press_row(const D& depth, Extent extent, Workspace& work, Index y) const {
    if (extent != Extent::changed) return membrane_.press(work.membrane, depth, y);
    if (!work.changes.is_needed(y)) return membrane_.leave_out(work.membrane, y);
    membrane_.press(work.membrane, depth, y, work.changes.columns());
  }

  template <class D>
  void bulge_band(const D& depth, Extent extent, Workspace& work, Index y) const {
    if (extent != Extent::changed) return membrane_.bulge(work.membrane, depth, y);
    work.changes.mark_beside(work.changed, y - 1, y + MembraneRows::band);
    membrane_.bulge(work.membrane, depth, y, work.changed.data());
  }

  template <class D>
  void render_row(ImageView<Rgb8> out, const D& depth, Extent extent, Workspace& work,
                  Index y) const {
    if (extent == Extent::changed) {
      if (!work.changes.any(y)) return;
      std::copy_n(work.changes.row(y), std::ssize(work.changed), work.changed.begin());
    } else {
      if (extent == Extent::not_at_rest) copy_rest(out, y);
      if (!membrane_.mark_changed(work.membrane, y, work.changed)) return;
    }
    detail::gather_runs(work.runs, work.changed.data(), camera_.width);
    if (work.runs.empty()) return;
    const bool darkens = options_.darkening > 0;
    if (darkens) {
      membrane_.protrusion(work.membrane, depth, y, work.kept.data());
      detail::vectorised([&] {
        detail::keep_row(work.kept.data(), static_cast<T>(options_.darkening),
                         static_cast<T>(options_.darkening_depth),
                         std::ptrdiff_t{detail::whole_blocks(camera_.width)});
      });
    }
    if constexpr (reads_touched) find_touched(depth, work, y);
    for (const detail::Run& run : work.runs) {
      shade_run(work, y, run, darkens ? work.kept.data() : nullptr);
    }
    if (membrane_.is_masked(y) || membrane_.has_holes(work.membrane, y)) {
      show_unknown(depth, work, y);
    }
    for (const detail::Run& run : work.runs) {
      detail::write_run(out, work.shading.packed.data(), y, run);
    }
  }

  // But for rounding: where a flat object lies on the gel, a mean over its protrusion may come out
  // a little larger than that, and the surface before the object.
  template <class D>
  void find_touched(const D& depth, Workspace& work, Index y) const {
    constexpr T share = 1 + 16 * std::numeric_limits<T>::epsilon();
    const T* const z = detail::row_of(depth, y, work.membrane.buffer.data(), camera_.width);
    const T* const rest = membrane_.rest(y);
    T* const touched = work.touched.data();
    for (const detail::Run& run : work.runs) {
      const T* const surface = membrane_.row(work.membrane, y, run);
      detail::vectorised([&] {
        for (Index x = run.begin; x < run.end; ++x) {
          touched[x] = z[x] > 0 && z[x] < rest[x] && z[x] <= share * surface[x] ? T(1) : T(0);
        }
      });
    }
  }

  void shade_run(Workspace& work, Index y, const detail::Run& run, const T* kept) const {
    const T *const above = membrane_.row(work.membrane, y - 1, run),
                   *const middle = membrane_.row(work.membrane, y, run),
                   *const below = membrane_.row(work.membrane, y + 1, run);
    const bool masked = !is_gaussian || masked_near(y);
    detail::for_each_tile(run, [&](const detail::Run& part) {
      const auto n = shading_.normals(work.shading, y, part, above, middle, below);
      if (masked) detail::clear_unknown(n, part.end - part.begin);
      if (options_.border_normals == BorderNormals::none) clear_border(n, y, part);
      if constexpr (reads_touched) {
        shading_.shade(work.shading, y, part, n, kept, work.touched.data());
      } else {
        shading_.shade(work.shading, y, part, n, kept);
      }
    });
  }

  [[nodiscard]] bool masked_near(Index y) const {
    const Index last = camera_.height - 1;
    return membrane_.is_masked(std::max(Index{0}, y - 1)) || membrane_.is_masked(y) ||
           membrane_.is_masked(std::min(last, y + 1));
  }

  void clear_border(const detail::VectorRow<T>& n, Index y, const detail::Run& run) const {
    const Index count = run.end - run.begin;
    for (T* const plane : {n.x, n.y, n.z}) {
      if (y == 0 || y == camera_.height - 1) std::fill_n(plane, count, T(0));
      if (run.begin == 0) plane[0] = 0;
      if (run.end == camera_.width) plane[count - 1] = 0;
    }
  }

  // Pixels whose depth or rest depth is not known show ambient light.
  template <class D>
  void show_unknown(const D& depth, Workspace& work, Index y) const {
    const T* const rest = membrane_.rest(y);
    for (const detail::Run& run : work.runs) {
      for (Index x = run.begin; x < run.end; ++x) {
        const T z = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
        if (detail::is_known(z) && detail::is_depth(rest[x])) continue;
        work.shading.packed[static_cast<std::size_t>(x)] = shading_.ambient_colour(x, y);
      }
    }
  }

  void copy_rest(ImageView<Rgb8> out, Index y) const {
    const Rgb8* const from = rest_image_.row(y);
    if (out.rows_are_packed()) {
      std::copy_n(from, camera_.width, out.row(y));
    } else {
      for (Index x = 0; x < camera_.width; ++x) out(x, y) = from[x];
    }
  }

  Camera<T> camera_;
  FrameOptions options_;
  MembraneRows membrane_;
  ShadedRows shading_;
  Image<Rgb8> rest_image_;
  mutable detail::Store<Workspace> workspaces_;
};

template <std::floating_point T, MembraneModel<T> Membrane, class Shine>
requires(Reflectance<Shine, T> || std::same_as<Shine, PhongLights<T>>)
    TactileRenderer<T, Membrane, Shine>::TactileRenderer(Direct, const Camera<T>& camera,
                                                         const View& rest_depth, Membrane membrane,
                                                         Shine shine, const FrameOptions& options)
    : camera_(camera),
      options_(checked(options, camera, rest_depth)),
      membrane_(membrane_rows(std::move(membrane), rest_depth, camera)),
      shading_(shaded_rows(camera, rest_depth, std::move(shine), options)),
      rest_image_(camera.width, camera.height) {
  render_all(rest_image_, rest_depth, Extent::everything);
}

template <std::floating_point T, MembraneModel<T> Membrane, class Shine>
requires(Reflectance<Shine, T> || std::same_as<Shine, PhongLights<T>>) void TactileRenderer<
    T, Membrane, Shine>::render_view(ImageView<Rgb8> out, const View& depth, Extent extent) const {
  lend_workspace([&](Workspace& work) { render_rows(out, depth, extent, work); });
}

template <std::floating_point T, MembraneModel<T> Membrane, class Shine>
requires(Reflectance<Shine, T> || std::same_as<Shine, PhongLights<T>>) void TactileRenderer<
    T, Membrane, Shine>::render_next_view(TactileFrame<T>& frame, const View& depth) const {
  render_next(frame, depth);
}

/// Deduces the type from the camera.
template <std::floating_point T, class D>
TactileRenderer(const Camera<T>&, const D&, const std::type_identity_t<std::vector<Light<T>>>&,
                const std::type_identity_t<Background<T>>& = {}, const TactileOptions& = {})
    -> TactileRenderer<T>;
/// Deduces the types from the camera and the models.
template <std::floating_point T, class D, MembraneModel<T> Membrane, class Shine>
TactileRenderer(const Camera<T>&, const D&, Membrane, Shine, const FrameOptions& = {})
    -> TactileRenderer<T, Membrane, Shine>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class TactileRenderer<float>;
GELIGHT_ONCE template class TactileRenderer<double>;
}  // namespace gelight
#endif
