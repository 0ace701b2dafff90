#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/normal_rows.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/sensor/rows/lines.hpp"
#include "gelight/sensor/rows/padded_rows.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/sensor/rows/surface_range.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// protrusion[i] = how far the contact is pressed in, 0 outside the membrane.
template <class T>
void protrusion_row(T* __restrict protrusion, const T* depth, const T* rest, T allowed,
                    std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T difference = rest[i] - contact_depth(depth[i], rest[i], allowed);
    protrusion[i] =
        difference == difference ? difference : 0;  // NOLINT(misc-redundant-expression): NaN
  }
}

/// out[i] = the contact's depth: a membrane that spreads nothing follows it.
template <class T>
void contact_row(T* __restrict out, const T* depth, const T* rest, T allowed,
                 std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    out[i] = not_too_near(contact_depth(depth[i], rest[i], allowed), rest[i]);
  }
}

/// out[i] = the smaller of the contact's depth and rest[i] - spread[i].
template <class T>
void bulge_row(T* __restrict out, const T* depth, const T* rest, const T* spread, T allowed,
               std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T contact = contact_depth(depth[i], rest[i], allowed);
    const T bulged = rest[i] - spread[i];
    out[i] = not_too_near(contact < bulged ? contact : bulged, rest[i]);
  }
}

/// Whether a row is known and its protrusion 0, as most rows of a small contact are. `allowed` is
/// 0 where what lies deeper than the membrane does not touch it, and otherwise the largest depth.
/// A loop for each question, without branches: so compilers vectorise it.
template <class T>
[[nodiscard]] bool row_is_at_rest(const T* depth, const T* rest, T allowed, std::ptrdiff_t count) {
  int moved = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) moved |= depth[i] < rest[i] ? 1 : 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) moved |= depth[i] > 0 ? 0 : 1;
  if (allowed == 0) return moved == 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    moved |= contact_depth(depth[i], rest[i], allowed) > rest[i] ? 1 : 0;
  }
  return moved == 0;
}

/// Whether a row has a depth that is not known where the membrane is.
template <class T>
[[nodiscard]] bool row_has_holes(const T* depth, const T* rest, std::ptrdiff_t count) {
  int unknown = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) unknown |= depth[i] > 0 ? 0 : 1;
  if (unknown == 0) return false;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    if (!is_known(depth[i]) && is_depth(rest[i])) return true;
  }
  return false;
}

/// Keeps the depth of a membrane at rest, NaN where there is none, and marks the rows that have
/// such pixels.
template <class T, class D>
void keep_rest_rows(PaddedRows<T>& rest, Array<char>& masked, const D& image, Index width,
                    Index height) {
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T z = static_cast<T>(ImageTraits<D>::pixel(image, x, y));
      rest.row(y)[x] = surface_or_nan(z);
      if (!is_depth(z)) masked[static_cast<std::size_t>(y)] = 1;
    }
  }
}

/// Rows of an image that slide along with a window, each of them kept twice: so all rows of the
/// window lie one after the other in memory, wherever it is.
template <class T>
class SlidingRows {
 public:
  SlidingRows() = default;
  /// `count` rows, the first of which is row -before of the image.
  SlidingRows(Index width, Index count, Index before)
      : count_(count),
        before_(before),
        stride_(row_stride(width)),
        numbers_(2 * static_cast<std::size_t>(count) * static_cast<std::size_t>(stride_)),
        used_(static_cast<std::size_t>(count)) {}

  /// Room for what symmetric_sums reads beyond the end, and an odd number of cache lines, so that
  /// the rows' numbers of one column do not compete for a few places in the cache.
  [[nodiscard]] static std::ptrdiff_t row_stride(Index width) {
    const std::ptrdiff_t lines = whole_lines<T>(width + column_step) / line_size<T>;
    return line_size<T> * (lines + 1 - lines % 2);
  }

  [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }
  [[nodiscard]] const T* row(Index y) const { return numbers_.data() + slot(y) * stride_; }

  /// Makes row y what `write(row)` writes into zeros.
  template <class Write>
  void set(Index y, const Write& write) {
    clear(y);
    T* const first = numbers_.data() + slot(y) * stride_;
    write(first);
    std::copy_n(first, stride_, first + count_ * stride_);
    used_[static_cast<std::size_t>(slot(y))] = 1;
  }

  void clear(Index y) {
    char& used = used_[static_cast<std::size_t>(slot(y))];
    if (used == 0) return;
    T* const first = numbers_.data() + slot(y) * stride_;
    std::fill_n(first, stride_, T(0));
    std::fill_n(first + count_ * stride_, stride_, T(0));
    used = 0;
  }

  void copy(Index y, Index from) {
    clear(y);
    if (used_[static_cast<std::size_t>(slot(from))] == 0) return;
    const T* const source = row(from);
    set(y, [&](T* out) { std::copy_n(source, stride_, out); });
  }

 private:
  [[nodiscard]] std::ptrdiff_t slot(Index y) const { return (y + before_) % count_; }

  Index count_ = 1, before_ = 0;
  std::ptrdiff_t stride_ = 0;
  Lines<T> numbers_;
  Array<char> used_;  // of each row: whether it is not all zero
};

/// The depth of an elastic membrane under contact, row after row: min(contact, rest - G(rest -
/// contact)), with the Gaussian G along each row as it comes in and then down the columns.
///
/// Where nothing within the Gaussian's reach differs from rest the membrane is exactly at rest, and
/// is not computed.
template <std::floating_point T>
class MembraneRows {
 public:
  /// How many rows of the membrane are made at once, an even number: the more, the less often the
  /// rows around them come out of the second cache.
  static constexpr Index band = 8;

  /// What changes while the rows of one image go through.
  struct Workspace {
    Lines<T> buffer;         // a row of depths
    Lines<T> padded;         // a row, `radius` more pixels on each side, and what fills a line
    SlidingRows<T> across;   // protrusion, smoothed along
    SlidingRows<T> missing;  // 1 where the depth is not known, smoothed along
    std::array<Lines<T>, band> spread, lack;  // the same, smoothed down
    Lines<T> membrane;  // rows of depth, a pixel more on each side: y at y mod (2 band)
    std::array<const T*, std::size_t{2} * band> rows{};  // where those rows are: there, or at rest
    std::array<Array<char>, 2> moved;  // of each block of two bands: whether not at rest
    Array<char> touched;               // of each block of a row
    Array<Index> newest;               // of each block: the last row that spreads into it
    Array<char> holes;                 // of each row: whether it has unknown depths
    Array<const T*> taps;
    Array<Run> runs;
    bool everything = false, any_holes = false;
  };

  /// `allowed` is 0 where what lies deeper than the membrane does not touch it, and otherwise the
  /// largest depth that pulls it.
  template <ImageOf<T> D>
  MembraneRows(const D& rest, Index width, Index height, std::vector<T> weights, T allowed)
      : width_(width),
        height_(height),
        radius_(static_cast<Index>(weights.size()) - 1),
        allowed_(allowed),
        weights_(std::move(weights)),
        zeros_(static_cast<std::size_t>(width)),
        rest_(width, height),
        masked_(static_cast<std::size_t>(height)) {
    keep_rest(rest);
  }

  /// How many rows below a row of the membrane are needed to make it.
  [[nodiscard]] Index radius() const { return radius_; }
  [[nodiscard]] const T* rest(Index y) const { return rest_.row(y); }

  /// Whether a row has pixels outside the membrane.
  [[nodiscard]] bool is_masked(Index y) const { return masked_[static_cast<std::size_t>(y)] != 0; }
  [[nodiscard]] bool has_holes(const Workspace& work, Index y) const {
    return work.holes[static_cast<std::size_t>(y)] != 0;
  }

  [[nodiscard]] Workspace make_workspace() const {
    const auto width = static_cast<std::size_t>(width_);
    const Index window = 2 * radius_ + 1;
    const auto blocks = static_cast<std::size_t>(block_count(width_));
    Workspace work;
    work.buffer.resize(width);
    work.padded.resize(width + static_cast<std::size_t>(2 * whole_lines<T>(radius_)));
    work.across = {width_, window + band - 1, radius_};
    work.missing = work.across;
    for (std::size_t r = 0; r < band; ++r) {
      work.spread[r].resize(static_cast<std::size_t>(work.across.stride()));
      work.lack[r] = work.spread[r];
    }
    work.membrane.resize(static_cast<std::size_t>(2 * band * stride()));
    for (auto& marks : work.moved) marks.resize(blocks);
    work.touched.resize(blocks);
    work.newest.resize(blocks);
    work.holes.resize(static_cast<std::size_t>(height_));
    work.taps.resize(static_cast<std::size_t>(window));
    work.runs.reserve(blocks);
    return work;
  }

  /// Forgets the last image; `everything` computes also what is at rest.
  void start(Workspace& work, bool everything) const {
    work.everything = everything;
    work.any_holes = false;
    std::fill(work.newest.begin(), work.newest.end(), -1 - radius_);
    std::fill(work.holes.begin(), work.holes.end(), char{0});
  }

  /// Takes in row y of the contact's depth, after row y - 1. Of the blocks that `wanted` does not
  /// mark, if there is one, nothing needs to be known.
  template <ImageOf<T> D>
  void press(Workspace& work, const D& image, Index y, const char* wanted = nullptr) const {
    const T* const depth = row_of(image, y, work.buffer.data(), width_);
    if (!work.everything &&
        vectorised([&] { return row_is_at_rest(depth, rest(y), allowed_, width_); })) {
      return leave_out(work, y);
    }
    press_holes(work, depth, y);
    T* const protrusion = work.padded.data() + whole_lines<T>(radius_);
    vectorised([&] { protrusion_row(protrusion, depth, rest(y), allowed_, width_); });
    if (!mark_touched(work, protrusion)) return work.across.clear(y);
    for (std::size_t b = 0; b < work.touched.size(); ++b) {
      if (work.touched[b] != 0) work.newest[b] = y;
    }
    if (radius_ == 0) return;
    if (wanted != nullptr) keep_marks(work.touched.data(), wanted, std::ssize(work.touched));
    gather_runs(work.runs, work.touched, width_);
    work.across.set(y, [&](T* out) { smooth_along(work, out); });
  }

  /// Takes in a row of which nothing needs to be known.
  void leave_out(Workspace& work, Index y) const {
    work.across.clear(y);
    work.missing.clear(y);
  }

  /// Makes the band of rows from y on, once row y + band - 1 + radius (or the last one) is in; only
  /// the blocks that `wanted` marks, if there is one.
  template <ImageOf<T> D>
  void bulge(Workspace& work, const D& image, Index y, const char* wanted = nullptr) const {
    auto& moved = work.moved[static_cast<std::size_t>(y / band % 2)];
    for (std::size_t b = 0; b < moved.size(); ++b) moved[b] = work.newest[b] >= y - radius_;
    if (wanted != nullptr) keep_marks(moved.data(), wanted, std::ssize(moved));
    gather_runs(work.runs, moved, width_);
    if (radius_ > 0) fill_border(work, y);
    if (radius_ > 0 && !work.runs.empty()) smooth_down(work, y);
    for (Index r = 0; r < std::min(band, height_ - y); ++r) {
      const T*& row = work.rows[static_cast<std::size_t>((y + r) % (2 * band))];
      row = rest(y + r);
      if (!work.runs.empty()) row = bulged_row(work, image, y + r);
    }
  }

  /// How far row y of the contact is pressed in, 0 where it does not touch or is not known.
  template <ImageOf<T> D>
  void protrusion(Workspace& work, const D& image, Index y, T* out) const {
    const T* const depth = row_of(image, y, work.buffer.data(), width_);
    vectorised([&] { protrusion_row(out, depth, rest(y), allowed_, width_); });
  }

  /// Row y of the membrane, a pixel more on each side, while the band after the next is not made.
  /// The rows before the first and after the last are extrapolated.
  [[nodiscard]] const T* row(Workspace& work, Index y) const {
    const auto slot = [](Index i) { return static_cast<std::size_t>((i + 2 * band) % (2 * band)); };
    if (y >= 0 && y < height_) return work.rows[slot(y)];
    const Index first = y < 0 ? 0 : height_ - 1;
    const Index second = std::clamp(y < 0 ? 1 : height_ - 2, Index{0}, height_ - 1);
    T* const outside = work.membrane.data() + stride() * static_cast<Index>(slot(y)) + line_size<T>;
    extrapolate_row(outside, work.rows[slot(first)], work.rows[slot(second)], width_);
    return outside;
  }

  /// Marks the blocks whose normals may differ from those at rest.
  void mark_changed(const Workspace& work, Index y, Array<char>& changed) const {
    std::fill(changed.begin(), changed.end(), static_cast<char>(has_holes(work, y)));
    const Index first = std::max(Index{0}, y - 1) / band,
                last = std::min(height_ - 1, y + 1) / band;
    for (Index b = first; b <= last; ++b) {
      mark_around(changed.data(), work.moved[static_cast<std::size_t>(b % 2)].data(),
                  std::ssize(changed));
    }
  }

 private:
  [[nodiscard]] std::ptrdiff_t stride() const { return PaddedRows<T>::stride(width_); }

  template <class D>
  void keep_rest(const D& image) {
    keep_rest_rows(rest_, masked_, image, width_, height_);
    for (Index y = 0; y < height_; ++y) extrapolate_ends(rest_.row(y), width_);
    if (radius_ > 0 && std::any_of(masked_.begin(), masked_.end(), [](char m) { return m != 0; })) {
      Image<T> outside(width_, height_);
      for (Index y = 0; y < height_; ++y) {
        for (Index x = 0; x < width_; ++x) outside(x, y) = is_depth(rest(y)[x]) ? 0 : 1;
      }
      lack_ = convolve_symmetric(outside, weights_, Border::reflect101);
    }
  }

  // Marks the blocks that the row's protrusion is spread into; false where there is none.
  [[nodiscard]] bool mark_touched(Workspace& work, const T* protrusion) const {
    auto& touched = work.touched;
    if (work.everything) {
      std::fill(touched.begin(), touched.end(), char{1});
      return true;
    }
    std::fill(touched.begin(), touched.end(), char{0});
    bool any = false;
    const Index blocks = block_count(width_), reach = (radius_ + block_size - 1) / block_size;
    for (Index b = 0; b < blocks; ++b) {
      const Index begin = b * block_size, end = std::min(width_, begin + block_size);
      const auto bytes = static_cast<std::size_t>(end - begin) * sizeof(T);
      if (std::memcmp(protrusion + begin, zeros_.data() + begin, bytes) == 0) continue;
      const Index first = std::max(Index{0}, b - reach), last = std::min(blocks - 1, b + reach);
      std::fill(touched.begin() + first, touched.begin() + last + 1, char{1});
      any = true;
    }
    return any;
  }

  // Smooths the padded row along itself, over the workspace's runs.
  void smooth_along(Workspace& work, T* out) const {
    T* const row = work.padded.data() + whole_lines<T>(radius_);
    for (Index k = 1; k <= radius_; ++k) {
      row[-k] = row[inside(-k, width_, Border::reflect101)];
      row[width_ - 1 + k] = row[inside(width_ - 1 + k, width_, Border::reflect101)];
    }
    const T** const taps = work.taps.data() + radius_;
    for (const Run& run : work.runs) {
      for (Index k = -radius_; k <= radius_; ++k) taps[k] = row + run.begin + k;
      vectorised([&] {
        symmetric_sum(out + run.begin, taps, weights_.data(), radius_, run.end - run.begin);
      });
    }
  }

  void press_holes(Workspace& work, const T* depth, Index y) const {
    if (!vectorised([&] { return row_has_holes(depth, rest(y), width_); })) {
      return work.missing.clear(y);
    }
    work.holes[static_cast<std::size_t>(y)] = 1;
    work.any_holes = true;
    if (radius_ == 0) return;
    T* const row = work.padded.data() + whole_lines<T>(radius_);
    for (Index x = 0; x < width_; ++x) row[x] = is_depth(rest(y)[x]) && !is_known(depth[x]) ? 1 : 0;
    work.runs.assign(1, {0, width_});
    work.missing.set(y, [&](T* out) { smooth_along(work, out); });
  }

  // Makes the rows beyond the image that the band from row y on is the first to need.
  void fill_border(Workspace& work, Index y) const {
    const auto fill = [&](Index first, Index last) {
      for (Index j = first; j <= last; ++j) {
        const Index from = inside(j, height_, Border::reflect101);
        work.across.copy(j, from);
        work.missing.copy(j, from);
      }
    };
    if (y == 0) fill(-radius_, -1);
    fill(std::max(height_, y == 0 ? height_ : y + radius_),
         std::min(height_ - 1, y + band - 1) + radius_);
  }

  // Smooths down the columns into `spread`, over the workspace's runs: a mean over the known
  // pixels.
  void smooth_down(Workspace& work, Index y) const {
    const Index count = std::min(band, height_ - y);
    sum_down(work, work.across, y, count, work.spread);
    const bool mask = lack_.width() > 0;
    if (!work.any_holes && !mask) return;
    if (work.any_holes) sum_down(work, work.missing, y, count, work.lack);
    for (Index r = 0; r < count; ++r) {
      auto& spread = work.spread[static_cast<std::size_t>(r)];
      const auto& missing = work.lack[static_cast<std::size_t>(r)];
      for (const Run& run : work.runs) {
        for (Index x = run.begin; x < run.end; ++x) {
          const auto i = static_cast<std::size_t>(x);
          const T lack = (work.any_holes ? missing[i] : 0) + (mask ? lack_(x, y + r) : 0);
          if (lack > 0) spread[i] = lack < 1 ? spread[i] / (1 - lack) : 0;
        }
      }
    }
  }

  // A few columns of all rows of the band at a time, so that they come from the first cache.
  void sum_down(const Workspace& work, const SlidingRows<T>& rows, Index y, Index count,
                std::array<Lines<T>, band>& out) const {
    const T* const middle = rows.row(y - radius_) + radius_ * rows.stride();
    for (const Run& run : work.runs) {
      vectorised([&] {
        for (Index x = run.begin; x < run.end; x += column_step) {
          for (Index r = 0; r < count; r += 2) {
            const auto i = static_cast<std::size_t>(r);
            symmetric_sums(out[i].data() + x, out[i + 1].data() + x, middle + r * rows.stride() + x,
                           rows.stride(), weights_.data(), radius_, column_step);
          }
        }
      });
    }
  }

  // Row y of the membrane: at rest but for the workspace's runs.
  template <class D>
  [[nodiscard]] const T* bulged_row(Workspace& work, const D& image, Index y) const {
    T* const z = work.membrane.data() + stride() * (y % (2 * band)) + line_size<T>;
    if (!work.everything) std::copy_n(rest(y), width_, z);
    const T* const depth = row_of(image, y, work.buffer.data(), width_);
    const T* const spread = work.spread[static_cast<std::size_t>(y % band)].data();
    for (const Run& run : work.runs) {
      const std::ptrdiff_t x = run.begin, count = run.end - run.begin;
      vectorised([&] {
        if (radius_ == 0) {
          contact_row(z + x, depth + x, rest(y) + x, allowed_, count);
        } else {
          bulge_row(z + x, depth + x, rest(y) + x, spread + x, allowed_, count);
        }
      });
    }
    extrapolate_ends(z, width_);
    return z;
  }

  Index width_, height_, radius_;
  T allowed_;
  std::vector<T> weights_, zeros_;
  PaddedRows<T> rest_;  // NaN outside the membrane
  Array<char> masked_;
  Image<T> lack_;  // the share of each pixel's Gaussian that lies outside the membrane, if any does
};

}  // namespace gelight::detail
