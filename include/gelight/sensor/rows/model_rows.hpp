#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <utility>

#include "gelight/concepts/image.hpp"
#include "gelight/concepts/membrane.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/normal_rows.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/sensor/rows/membrane_rows.hpp"
#include "gelight/sensor/rows/padded_rows.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/sensor/rows/surface_range.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// The surface of any membrane model under contact, row after row. The model is asked for no more
/// than a contact can have moved, and for nothing where there is none.
template <std::floating_point T, MembraneModel<T> M>
class ModelRows {
 public:
  /// What changes while the rows of one image go through.
  struct Workspace {
    Lines<T> buffer;        // a row of depths
    Image<T> depth;         // of a frame that is not of T, not packed, or may leave the range
    PaddedRows<T> surface;  // at rest but for `moved`
    Window moved;           // whole blocks
    Array<char> holes;      // of each row: whether it has unknown depths
    decltype(std::declval<const M&>().make_workspace(Index{}, Index{})) model;
    bool everything = false;
  };

  /// `deepest` is the largest depth of a surface.
  template <ImageOf<T> D>
  ModelRows(M model, const D& rest, Index width, Index height, T deepest)
      : model_(std::move(model)),
        width_(width),
        height_(height),
        deepest_(deepest),
        reach_(std::clamp(static_cast<Index>(model_.reach()), Index{0}, std::max(width, height))),
        rest_(width, height),
        masked_(static_cast<std::size_t>(height)),
        farthest_(static_cast<std::size_t>(height)) {
    keep_rest_rows(rest_, masked_, farthest_, rest, width, height);
    extend(rest_, {0, 0, width, height});
  }

  /// How far from a contact the surface can differ from rest.
  [[nodiscard]] Index radius() const { return reach_; }
  [[nodiscard]] const T* rest(Index y) const { return rest_.row(y); }

  /// Whether a row has pixels outside the membrane, or unknown ones in it.
  ///@{
  [[nodiscard]] bool is_masked(Index y) const { return masked_[static_cast<std::size_t>(y)] != 0; }
  [[nodiscard]] bool has_holes(const Workspace& work, Index y) const {
    return work.holes[static_cast<std::size_t>(y)] != 0;
  }
  ///@}

  [[nodiscard]] Workspace make_workspace() const {
    Workspace work{{}, {}, rest_, {}, {}, model_.make_workspace(width_, height_)};
    work.buffer.resize(static_cast<std::size_t>(width_));
    work.depth = Image<T>(width_, height_);
    work.holes.resize(static_cast<std::size_t>(height_));
    return work;
  }

  /// Takes in an image of the contact's depth; of the surface, no more than `wanted`, whole blocks,
  /// needs to be known. `everything` computes also what is at rest.
  template <ImageOf<T> D>
  void press(Workspace& work, const D& image, bool everything, const Window& wanted) const {
    const ImageView<const T> depth = in_range(work, packed(work, image));
    work.everything = everything;
    restore(work);
    const Window contact = find_contact(work, depth);
    const Window touched = moves_untouched() ? Window{0, 0, width_, height_} : contact;
    work.moved = everything ? touched.grown(whole_image, width_, height_)
                            : whole_blocks(touched.grown(reach_, width_, height_)).common(wanted);
    if (touched.is_empty() || work.moved.is_empty()) {
      work.moved = {};
    } else {
      model_.press_into(work.surface.view(), {depth, rest_.view(), work.moved}, work.model);
      keep_in_range(work);
    }
    extend(work.surface, work.moved);
  }

  /// How far row y of the contact is pressed in, 0 where it does not touch or is not known.
  template <ImageOf<T> D>
  void protrusion(Workspace& work, const D& image, Index y, T* out) const {
    const T* const depth = row_of(image, y, work.buffer.data(), width_);
    vectorised([&] { protrusion_row(out, depth, rest(y), allowed(), width_); });
  }

  /// Row y of the surface, from -1 to the height, a pixel more on each side; beyond the image it is
  /// extrapolated.
  [[nodiscard]] const T* row(const Workspace& work, Index y, const Run&) const {
    return work.surface.row(y);
  }

  /// Marks the blocks whose normals may differ from those at rest; false where there are none.
  bool mark_changed(const Workspace& work, Index y, Array<char>& changed) const {
    const bool whole_row = work.everything || has_holes(work, y);
    const Window near = work.moved.grown(1, width_, height_);
    const bool is_near = !near.is_empty() && y >= near.top && y < near.bottom;
    if (!whole_row && !is_near) return false;
    std::fill(changed.begin(), changed.end(), static_cast<char>(whole_row));
    if (!is_near) return true;
    std::fill(changed.begin() + near.left / block_size,
              changed.begin() + (near.right - 1) / block_size + 1, char{1});
    return true;
  }

 private:
  // Whether the surface may differ from rest without a contact in the image.
  [[nodiscard]] static constexpr bool moves_untouched() {
    if constexpr (requires { M::moves_untouched; }) return M::moves_untouched;
    return false;
  }

  template <class D>
  [[nodiscard]] ImageView<const T> packed(Workspace& work, const D& image) const {
    if constexpr (std::convertible_to<const D&, ImageView<const T>>) {
      const ImageView<const T> view = image;
      if (view.rows_are_packed()) return view;
    }
    for (Index y = 0; y < height_; ++y) {
      const T* const row = row_of(image, y, work.buffer.data(), width_);
      std::copy_n(row, width_, work.depth.row(y));
    }
    return std::as_const(work.depth).view();
  }

  // What lies beyond the range of depths is nothing to a membrane that it might pull.
  [[nodiscard]] ImageView<const T> in_range(Workspace& work,
                                            const ImageView<const T>& depth) const {
    if (allowed() == 0) return depth;
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        const T z = depth(x, y);
        work.depth(x, y) = z > deepest_ ? std::numeric_limits<T>::infinity() : z;
      }
    }
    return std::as_const(work.depth).view();
  }

  [[nodiscard]] Window whole_blocks(const Window& window) const {
    if (window.is_empty()) return {};
    return {window.left / block_size * block_size, window.top,
            std::min(width_, block_count(window.right) * block_size), window.bottom};
  }

  // Makes the surface what it is at rest.
  void restore(Workspace& work) const {
    const Window& moved = work.moved;
    for (Index y = moved.top; y < moved.bottom; ++y) {
      T* const surface = work.surface.row(y);
      std::copy(rest(y) + moved.left, rest(y) + moved.right, surface + moved.left);
      surface[-1] = rest(y)[-1];
      surface[width_] = rest(y)[width_];
    }
  }

  // 0 where what lies deeper than the membrane does not touch it, and otherwise the largest depth
  // that pulls it.
  [[nodiscard]] T allowed() const {
    if constexpr (requires { model_.clips_to_rest(); }) {
      if (!model_.clips_to_rest()) return deepest_;
    }
    return 0;
  }

  // Where something touches the membrane, or pulls it. Notes what is not known.
  [[nodiscard]] Window find_contact(Workspace& work, const ImageView<const T>& depth) const {
    Window touched{width_, height_, 0, 0};
    const T most = allowed();
    for (Index y = 0; y < height_; ++y) {
      const T* const z = depth.row(y);
      const T* const r = rest(y);
      char& holes = work.holes[static_cast<std::size_t>(y)];
      holes = 0;
      if (vectorised([&] { return row_is_at_rest(z, r, farthest_[y], most, width_); })) continue;
      holes = vectorised([&] { return row_has_holes(z, r, width_); });
      const auto touches = [&](Index x) {
        const T contact = contact_depth(z[x], r[x], most);
        return contact < r[x] || contact > r[x];
      };
      Index left = 0, right = width_;
      while (left < width_ && !touches(left)) ++left;
      if (left == width_) continue;
      while (!touches(right - 1)) --right;
      touched = {std::min(touched.left, left), std::min(touched.top, y),
                 std::max(touched.right, right), y + 1};
    }
    return touched.is_empty() ? Window{} : touched;
  }

  void keep_in_range(Workspace& work) const {
    const Window& moved = work.moved;
    for (Index y = moved.top; y < moved.bottom; ++y) {
      T* const surface = work.surface.row(y);
      const T* const r = rest(y);
      vectorised([&] {
        for (Index x = moved.left; x < moved.right; ++x) {
          const T z = not_too_near(surface[x], r[x]);
          surface[x] = z > deepest_ ? deepest_ : z;
        }
      });
    }
  }

  // Makes what is beside an image of which a window has changed.
  void extend(PaddedRows<T>& rows, const Window& changed) const {
    for (Index y = changed.top; y < changed.bottom; ++y) extrapolate_ends(rows.row(y), width_);
    const Index last = height_ - 1, second = std::min(Index{1}, last);
    extrapolate_row(rows.row(-1), rows.row(0), rows.row(second), width_);
    extrapolate_row(rows.row(height_), rows.row(last), rows.row(last - second), width_);
  }

  M model_;
  Index width_, height_;
  T deepest_;
  Index reach_;
  PaddedRows<T> rest_;  // NaN outside the membrane
  Array<char> masked_;
  Array<T> farthest_;
};

}  // namespace gelight::detail
