#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/membrane/bulge/coarse_layer.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/membrane/layer/green.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// How exact a bulging membrane is, and how dear.
struct BulgeOptions {
  /// Contacts are looked for on squares of pixels so large that no more than this many of them,
  /// across or down, cover what stands in the gel.
  Index cells = 32;
  int kernels = 4;           ///< how many products stand for the layer's Green's function
  int iterations = 10;       ///< of conjugate gradients, at most
  double tolerance = 0.005;  ///< how far the surface may be from the object, of the deepest press
};

namespace detail {

/// The surface that sinks by `down` from where it rests, and is the object where that would be in
/// it, or no farther off than `near`.
template <class T>
void lay_row(T* __restrict surface, const T* depth, const T* rest, const T* down, const T* near,
             std::ptrdiff_t count) {
  for (std::ptrdiff_t x = 0; x < count; ++x) {
    const T in = depth[x] > 0 ? rest[x] - depth[x] : -std::numeric_limits<T>::infinity();
    surface[x] = rest[x] - (in > down[x] - near[x] ? in : down[x]);
  }
}

}  // namespace detail

/// An elastic layer on a rigid base as a cheap membrane model: what is pressed in pushes the gel
/// aside, so that a thin one that keeps its volume rises around the contact, and a thick one sinks
/// farther away than a Gaussian does.
///
/// The contact's pressure is found on a coarse grid, with the Green's function of ElasticLayer as a
/// sum of a few products of functions of x and y (its largest singular vectors); the surface it
/// makes is interpolated by cubics between the cells, and is the object itself where that touches.
/// Against a converged ElasticLayer normals are more than twice as near as the best Gaussian's (of
/// a sigma that nobody knows beforehand), and four times in the geometric mean, for balls, ridges,
/// gratings, blocks and two points on gels of Poisson ratio 0.3 to 0.5; but not those of steep
/// edges, nor in a compressible gel that is no thicker than a few cells, nor of what repeats within
/// six cells: there a Gaussian may be nearer, and of ridges two cells apart even the gel at rest.
///
/// The cells, of two pixels or more, stay where they are on the image. A move by two moves the
/// surface with the object, to 0.2 % of the press; one by a pixel also changes it, beside the
/// upright sides of a block by up to six tenths of the press (nine on a gel of 5 pixels), a
/// ball's by up to 3.5 %. Where such sides move from frame to frame that flickers;
/// the surface of a LayerMembrane changes by less than 0.2 %. (A test holds these bounds.)
///
/// A frame of 320 x 240 takes 1.2 to 2 times what a Gaussian of sigma 5 takes for the whole
/// image; nothing depends on what was pressed before. A model of the concept MembraneModel. Unlike
/// an ElasticLayer it tells no pressure, no force and no sideways displacement.
template <std::floating_point T>
class BulgingMembrane {
 public:
  /// `rest_depth` is the gel's mean depth, in m, as are all depths. Throws InvalidInput for a
  /// camera that is not valid, a rest depth that is not positive and finite, a thickness below a
  /// tenth of a pixel or not positive, a Poisson ratio outside of [0, 0.5], options that are not
  /// positive, and a tolerance of 1 or more. (Neither the modulus nor friction and tension change
  /// the surface.)
  BulgingMembrane(const Camera<T>& camera, std::type_identity_t<T> rest_depth, const Gel& gel = {},
                  const BulgeOptions& options = {})
      : options_(options),
        width_(camera.width),
        height_(camera.height),
        bulges_(gel.poisson_ratio > hardly_rises && std::isfinite(gel.thickness)) {
    camera.require_valid();
    detail::require(rest_depth > 0 && std::isfinite(rest_depth), "rest depth ", rest_depth,
                    " is not positive and finite");
    detail::require(gel.poisson_ratio >= 0 && gel.poisson_ratio <= 0.5, "Poisson ratio ",
                    gel.poisson_ratio, " is not between 0 and 0.5");
    const double pixel = double{rest_depth} / double{camera.fx};
    const double aspect = double{camera.fx} / double{camera.fy};
    detail::require(gel.thickness >= 0.1 * pixel * std::max(1.0, aspect), "gel thickness ",
                    gel.thickness, " is not positive, or below a tenth of a pixel, which is ",
                    pixel * std::max(1.0, aspect), " wide");
    detail::require(options.cells > 0, options.cells, " cells are not positive");
    detail::require(options.kernels > 0, options.kernels, " kernels are not positive");
    detail::require(options.iterations > 0, options.iterations, " iterations are not positive");
    detail::require(options.tolerance > 0 && options.tolerance < 1, "tolerance ", options.tolerance,
                    " is not between 0 and 1");
    // No image has more cells than pixels.
    options_.cells = std::min(options.cells, std::max(width_, height_));
    const detail::LayerGrid pixels{width_, height_, aspect, gel.thickness / pixel,
                                   gel.poisson_ratio};
    auto levels = std::make_shared<std::vector<detail::CoarseLayer<T>>>();
    do {
      // Below two pixels the cells far away cost more than they gain.
      levels->emplace_back(pixels, Index{2} << levels->size(), options.kernels);
    } while (std::max(levels->back().width(), levels->back().height()) > options_.cells);
    levels_ = std::move(levels);
  }

  /// The memory that `press_into` works in.
  struct Workspace {
    detail::CoarseContact<T> contact;  ///< of the object's cells
    std::vector<T> part;               ///< of a product, half done
    std::vector<T> sunk;               ///< the cells around the window
    std::vector<T> across;             ///< the same, between the cells of each row
    std::vector<T> down;               ///< a row of pixels
    std::vector<T> near;               ///< how near to each pixel of a row an object holds it
  };

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const { return whole_image; }
  /// Throws InvalidInput for another size than the camera's.
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    detail::require(width == width_ && height == height_, "images of ", width, " x ", height,
                    " pixels are not of the camera's ", width_, " x ", height_);
    const auto& fine = levels_->front();
    const auto columns = static_cast<std::size_t>(width),
               box = static_cast<std::size_t>(most_box());
    const auto cells_across = static_cast<std::size_t>(fine.width());
    const auto cells_down = static_cast<std::size_t>(fine.height());
    return {detail::CoarseContact<T>(box * box),
            std::vector<T>(box * cells_across),
            std::vector<T>(cells_across * cells_down),
            std::vector<T>(columns * cells_down),
            std::vector<T>(columns),
            std::vector<T>(columns)};
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    const Touch touch = find(press);
    if (!(touch.deepest > 0)) {
      for_each(press.window, [&](Index x, Index y) { surface(x, y) = press.rest(x, y); });
      return;
    }
    const auto& layer = level(touch.pixels);
    const detail::Cells box = cells(layer, touch.pixels);
    read_object(press, layer, box, work);
    work.contact.solve(layer, box, static_cast<T>(options_.tolerance) * touch.deepest,
                       options_.iterations, work.part.data());
    write(surface, press, layer, box, touch.deepest, work);
  }
  ///@}

  /// The depth of the surface under what a depth image shows, in front of a gel at rest, both in m.
  /// NaN where there is no gel or the object's depth is not known. Throws InvalidInput for images
  /// of another size than the camera's.
  [[nodiscard]] Image<T> depth(const Image<T>& object, const Image<T>& rest) const {
    for (const auto* image : {&object, &rest}) {
      detail::require(image->width() == width_ && image->height() == height_, "a depth image of ",
                      image->width(), " x ", image->height(), " pixels is not of the camera's ",
                      width_, " x ", height_);
    }
    Image<T> gel = rest, surface(width_, height_);
    for (T& z : gel.pixels()) z = detail::surface_or_nan(z);
    Workspace work = make_workspace(width_, height_);
    press_into(surface, {object.view(), gel.view(), {0, 0, width_, height_}}, work);
    for (std::size_t i = 0; i < surface.pixels().size(); ++i) {
      if (!detail::is_known(object.pixels()[i])) {
        surface.pixels()[i] = std::numeric_limits<T>::quiet_NaN();
      }
    }
    return surface;
  }

 private:
  // The Poisson ratio below which no gel rises by more than 1.3 % of the press.
  static constexpr double hardly_rises = 0.25;

  struct Touch {
    Window pixels;
    T deepest = 0;
  };

  template <class Work>
  static void for_each(const Window& window, const Work& work) {
    for (Index y = window.top; y < window.bottom; ++y) {
      for (Index x = window.left; x < window.right; ++x) work(x, y);
    }
  }

  // How many cells a contact's box has at most across or down.
  [[nodiscard]] Index most_box() const {
    const Index object = options_.cells + 2;
    return object + (bulges_ ? 2 * (object / 4 + 1) : 0);
  }

  // Where the object stands in the gel.
  [[nodiscard]] Touch find(const Press<T>& press) const {
    Touch touch{{width_, height_, 0, 0}, 0};
    for (Index y = 0; y < height_; ++y) {
      const T *const z = press.depth.row(y), *const rest = press.rest.row(y);
      const bool is_touched = detail::vectorised([&] {
        int any = 0;
        for (Index x = 0; x < width_; ++x) any |= (z[x] > 0 ? 1 : 0) & (z[x] < rest[x] ? 1 : 0);
        return any != 0;
      });
      if (!is_touched) continue;
      Index left = width_, right = 0;
      for (Index x = 0; x < width_; ++x) {
        if (!(z[x] > 0 && z[x] < rest[x])) continue;
        touch.deepest = std::max(touch.deepest, rest[x] - z[x]);
        left = std::min(left, x);
        right = x + 1;
      }
      touch.pixels = {std::min(touch.pixels.left, left), std::min(touch.pixels.top, y),
                      std::max(touch.pixels.right, right), y + 1};
    }
    return touch;
  }

  [[nodiscard]] const detail::CoarseLayer<T>& level(const Window& object) const {
    const Index size = std::max(object.right - object.left, object.bottom - object.top);
    std::size_t i = 0;
    while (i + 1 < levels_->size() && size > options_.cells * (*levels_)[i].step()) ++i;
    return (*levels_)[i];
  }

  // Those of the object, and as many more as it may touch where the gel bulges.
  [[nodiscard]] detail::Cells cells(const detail::CoarseLayer<T>& layer,
                                    const Window& object) const {
    const Index s = layer.step();
    Window box{object.left / s, object.top / s, (object.right - 1) / s + 1,
               (object.bottom - 1) / s + 1};
    const Index size = std::max(box.right - box.left, box.bottom - box.top);
    if (bulges_) box = box.grown(size / 4 + 1, layer.width(), layer.height());
    return {box.left, box.top, box.right - box.left, box.bottom - box.top};
  }

  // The mean of the object's pixels in each cell that it covers by half.
  void read_object(const Press<T>& press, const detail::CoarseLayer<T>& layer,
                   const detail::Cells& box, Workspace& work) const {
    constexpr T nothing = -std::numeric_limits<T>::infinity();
    const Index s = layer.step();
    for (Index j = 0; j < box.height; ++j) {
      for (Index i = 0; i < box.width; ++i) {
        const Index x0 = (box.left + i) * s, y0 = (box.top + j) * s;
        const Window cell{x0, y0, std::min(width_, x0 + s), std::min(height_, y0 + s)};
        T sum = 0;
        Index covered = 0, all = 0;
        for_each(cell, [&](Index x, Index y) {
          const T z = press.depth(x, y), in = press.rest(x, y) - z;
          ++all;
          if (!detail::is_depth(z) || std::isnan(in)) return;
          sum += in;
          ++covered;
        });
        work.contact.wanted[box.at(i, j)] =
            2 * covered >= all ? sum / static_cast<T>(covered) : nothing;
      }
    }
  }

  // Catmull and Rom's weights of four neighbours at a share of the way between the middle two.
  [[nodiscard]] static std::array<T, 4> cubic(T t) {
    const T square = t * t, cube = square * t;
    return {(2 * square - t - cube) / 2, (3 * cube - 5 * square + 2) / 2,
            (4 * square + t - 3 * cube) / 2, (cube - square) / 2};
  }

  // Of a pixel: the first of the four cells around it, and their weights.
  [[nodiscard]] static std::pair<Index, std::array<T, 4>> around(Index pixel, Index step) {
    const Index twice = 2 * pixel + 1 - step;  // 2 step cells' places
    const Index before = twice < 0 ? -1 : twice / (2 * step);
    const T t = static_cast<T>(twice - before * 2 * step) / static_cast<T>(2 * step);
    return {before - 1, cubic(t)};
  }

  void write(ImageView<T> surface, const Press<T>& press, const detail::CoarseLayer<T>& layer,
             const detail::Cells& box, T deepest, Workspace& work) const {
    const Index s = layer.step();
    const Window& window = press.window;
    const Window near = Window{window.left / s, window.top / s, (window.right - 1) / s + 1,
                               (window.bottom - 1) / s + 1}
                            .grown(2, layer.width(), layer.height());
    const detail::Cells cells{near.left, near.top, near.right - near.left, near.bottom - near.top};
    layer.sink(work.sunk.data(), cells, work.contact.pressure.data(), box, work.part.data());
    // Along the rows of cells first: they are fewer than the rows of pixels.
    for (Index row = 0; row < cells.height; ++row) {
      const T* const sunk = work.sunk.data() + cells.at(0, row);
      T* const out = work.across.data() + std::ptrdiff_t{row} * width_;
      for (Index x = window.left; x < window.right; ++x) {
        const auto [first, weights] = around(x, s);
        T sum = 0;
        for (Index k = 0; k < 4; ++k) {
          sum += weights[static_cast<std::size_t>(k)] *
                 sunk[std::clamp(first + k - cells.left, Index{0}, cells.width - 1)];
        }
        out[x] = sum;
      }
    }
    Index held = -1;
    for (Index y = window.top; y < window.bottom; ++y) {
      if (y / s != held) {
        held = y / s;
        mark_held(work, box, window, held, s, deepest);
      }
      const std::pair<Index, std::array<T, 4>> four = around(y, s);
      std::array<const T*, 4> rows{};
      for (Index k = 0; k < 4; ++k) {
        const Index row = std::clamp(four.first + k - cells.top, Index{0}, cells.height - 1);
        rows[static_cast<std::size_t>(k)] =
            work.across.data() + std::ptrdiff_t{row} * width_ + window.left;
      }
      T* const down = work.down.data();
      const auto count = static_cast<std::ptrdiff_t>(window.right - window.left);
      std::fill_n(down, count, T(0));
      detail::vectorised([&] {
        detail::add_four_rows(down, four.second, rows, count);
        detail::lay_row(surface.row(y) + window.left, press.depth.row(y) + window.left,
                        press.rest.row(y) + window.left, down, work.near.data() + window.left,
                        count);
      });
    }
  }

  // So near to an object that touches all around, the surface is its own: what the coarse grid
  // leaves between them is error. For the pixels of a row of cells.
  void mark_held(Workspace& work, const detail::Cells& box, const Window& window, Index row,
                 Index s, T deepest) const {
    constexpr T share = static_cast<T>(0.05);
    for (Index x = window.left; x < window.right;) {
      const Index end = std::min(window.right, (x / s + 1) * s);
      const T near = is_held(work, box, x / s, row) ? share * deepest : T(0);
      std::fill(work.near.data() + x, work.near.data() + end, near);
      x = end;
    }
  }

  // Whether a cell and all around it are pressed.
  [[nodiscard]] bool is_held(const Workspace& work, const detail::Cells& box, Index column,
                             Index row) const {
    const Index x = column - box.left, y = row - box.top;
    if (x < 1 || y < 1 || x + 1 >= box.width || y + 1 >= box.height) return false;
    bool is_pressed = true;
    for (Index j = y - 1; j <= y + 1; ++j) {
      for (Index i = x - 1; i <= x + 1; ++i) {
        is_pressed = is_pressed && work.contact.pressure[box.at(i, j)] > 0;
      }
    }
    return is_pressed;
  }

  BulgeOptions options_;
  Index width_, height_;
  bool bulges_;
  std::shared_ptr<const std::vector<detail::CoarseLayer<T>>> levels_;
};

}  // namespace gelight
