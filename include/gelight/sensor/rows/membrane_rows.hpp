#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/normal_rows.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/smoothing.hpp"
#include "gelight/sensor/rows/lines.hpp"
#include "gelight/sensor/rows/near_blocks.hpp"
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

/// Whether a tile's depths are known and none is nearer than `farthest`.
template <class T>
[[nodiscard]] bool tile_is_behind(const T* depth, T farthest) {
  int is_near = 0;
  for (Index i = 0; i < tile_width; ++i) is_near |= depth[i] >= farthest ? 0 : 1;
  return is_near == 0;
}

/// Whether a row is known where the membrane is and its protrusion 0, as most rows of a small
/// contact are. `farthest` is the largest rest depth of the row; of tiles at its ends that lie
/// behind that, the rest depth is not even fetched. `allowed` is 0 where what lies deeper than the
/// membrane does not touch it, and otherwise the largest depth. Loops without branches: so
/// compilers vectorise them.
template <class T>
[[nodiscard]] bool row_is_at_rest(const T* depth, const T* rest, T farthest, T allowed,
                                  std::ptrdiff_t count) {
  std::ptrdiff_t begin = 0;
  if (allowed == 0) {
    while (begin + tile_width <= count && tile_is_behind(depth + begin, farthest)) {
      begin += tile_width;
    }
    while (begin + tile_width <= count && tile_is_behind(depth + count - tile_width, farthest)) {
      count -= tile_width;
    }
  }
  int moved = 0;
  for (std::ptrdiff_t i = begin; i < count; ++i) {
    const int is_behind = depth[i] >= rest[i] ? 1 : 0;
    const int is_outside = rest[i] == rest[i] ? 0 : 1;  // NOLINT(misc-redundant-expression): NaN
    moved |= 1 - (is_behind | is_outside);
  }
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

/// Keeps the depth of a membrane at rest, NaN where there is none, marks the rows that have such
/// pixels, and notes the largest depth of each row.
template <class T, class D>
void keep_rest_rows(PaddedRows<T>& rest, Array<char>& masked, Array<T>& farthest, const D& image,
                    Index width, Index height) {
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T z = static_cast<T>(ImageTraits<D>::pixel(image, x, y));
      rest.row(y)[x] = surface_or_nan(z);
      if (!is_depth(z)) {
        masked[static_cast<std::size_t>(y)] = 1;
      } else {
        farthest[y] = std::max(farthest[y], z);
      }
    }
  }
}

/// Marks the blocks that have a number other than 0.
template <class T>
void mark_blocks(char* __restrict marks, const T* row, std::ptrdiff_t blocks) {
  for (std::ptrdiff_t b = 0; b < blocks; ++b) {
    int any = 0;
    for (Index i = 0; i < block_size; ++i) any |= row[b * block_size + i] == 0 ? 0 : 1;
    marks[b] = static_cast<char>(any);
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
        used_(static_cast<std::size_t>(count), Run{0, 0}) {}

  /// Room for what symmetric_sums reads beyond the end, and an odd number of cache lines, so that
  /// the rows' numbers of one column do not compete for a few places in the cache.
  [[nodiscard]] static std::ptrdiff_t row_stride(Index width) {
    const std::ptrdiff_t lines = whole_lines<T>(width + column_step) / line_size<T>;
    return line_size<T> * (lines + 1 - lines % 2);
  }

  [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }
  [[nodiscard]] const T* row(Index y) const { return numbers_.data() + slot(y) * stride_; }

  /// Makes row y what `write(row)` writes into zeros, no further than some columns.
  template <class Write>
  void set(Index y, const Run& columns, const Write& write) {
    clear(y);
    T* const first = numbers_.data() + slot(y) * stride_;
    write(first);
    std::copy(first + columns.begin, first + columns.end, first + count_ * stride_ + columns.begin);
    used_[slot(y)] = columns;
  }

  void clear(Index y) {
    Run& used = used_[slot(y)];
    if (used.end == 0) return;
    T* const first = numbers_.data() + slot(y) * stride_;
    std::fill(first + used.begin, first + used.end, T(0));
    std::fill(first + count_ * stride_ + used.begin, first + count_ * stride_ + used.end, T(0));
    used = {0, 0};
  }

  void copy(Index y, Index from) {
    clear(y);
    const Run columns = used_[slot(from)];
    if (columns.end == 0) return;
    const T* const source = row(from);
    set(y, columns, [&](T* out) {
      std::copy(source + columns.begin, source + columns.end, out + columns.begin);
    });
  }

 private:
  [[nodiscard]] std::ptrdiff_t slot(Index y) const { return (y + before_) % count_; }

  Index count_ = 1, before_ = 0;
  std::ptrdiff_t stride_ = 0;
  Lines<T> numbers_;
  Array<Run> used_;  // of each row: the columns that are not all zero
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
    Lines<T> buffer;         // a row of depths, and what fills a block: nothing is there
    Lines<T> padded;         // a row, `radius` more pixels on each side, and what fills a line
    SlidingRows<T> across;   // protrusion, smoothed along
    SlidingRows<T> missing;  // 1 where the depth is not known, smoothed along
    std::array<Lines<T>, band> sums, lack;  // the same, smoothed down
    Lines<T> membrane;  // rows of depth, a pixel more on each side: y at y mod (2 band)
    std::array<Run, std::size_t{2} * band> made;  // the columns of those rows that are there
    Array<char> touched;  // of each block of a row: whether the contact's protrusion is there
    Array<char> spread;   // of each block of a row: whether that is spread into it, or beside it
    Array<char> moved;    // of each block of a band
    NearBlocks near;      // whose normals may not be at rest
    Array<char> holes;    // of each row: whether it has unknown depths
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
        rest_(width, height),
        masked_(static_cast<std::size_t>(height)),
        farthest_(static_cast<std::size_t>(height)) {
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
    const auto whole = static_cast<std::size_t>(whole_blocks(width_));
    const Index window = 2 * radius_ + 1;
    const auto blocks = static_cast<std::size_t>(block_count(width_));
    Workspace work;
    work.buffer.resize(whole, std::numeric_limits<T>::infinity());
    work.padded.resize(whole + static_cast<std::size_t>(2 * whole_lines<T>(radius_)));
    work.across = {width_, window + band - 1, radius_};
    work.missing = work.across;
    for (std::size_t r = 0; r < band; ++r) {
      work.sums[r].resize(static_cast<std::size_t>(work.across.stride()));
      work.lack[r] = work.sums[r];
    }
    work.membrane.resize(static_cast<std::size_t>(2 * band * stride()));
    for (auto* const marks : {&work.touched, &work.spread, &work.moved}) marks->resize(blocks);
    work.near = {width_, height_, radius_ + 1};
    work.holes.resize(static_cast<std::size_t>(height_));
    work.taps.resize(static_cast<std::size_t>(window));
    work.runs.reserve(blocks);
    return work;
  }

  /// Forgets the last image; `everything` computes also what is at rest.
  void start(Workspace& work, bool everything) const {
    work.everything = everything;
    work.any_holes = false;
    work.near.reset(everything);
    std::fill(work.holes.begin(), work.holes.end(), char{0});
  }

  /// Takes in row y of the contact's depth, after row y - 1. Of the blocks that `wanted` does not
  /// mark, if there is one, nothing needs to be known.
  template <ImageOf<T> D>
  void press(Workspace& work, const D& image, Index y, const char* wanted = nullptr) const {
    const T* const depth = whole_row_of(image, y, work.buffer.data(), width_);
    if (!work.everything && vectorised([&] {
          return row_is_at_rest(depth, rest(y), farthest_[y], allowed_, whole_width());
        })) {
      return leave_out(work, y);
    }
    press_holes(work, depth, y);
    T* const protrusion = work.padded.data() + whole_lines<T>(radius_);
    vectorised([&] {
      protrusion_row(protrusion, depth, rest(y), allowed_, whole_width());
      if (!work.everything) mark_blocks(work.touched.data(), protrusion, block_count(width_));
    });
    if (!mark_spread(work, protrusion, y)) return work.across.clear(y);
    if (radius_ == 0) return;
    if (wanted != nullptr) keep_marks(work.spread.data(), wanted, std::ssize(work.spread));
    gather_runs(work.runs, work.spread.data(), width_);
    if (work.runs.empty()) return work.across.clear(y);
    const Run columns{work.runs.front().begin, work.runs.back().end};
    work.across.set(y, columns, [&](T* out) { smooth_along(work, out); });
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
    if (radius_ > 0) fill_border(work, y);
    Index first = y, last = std::min(height_, y + band);
    for (Index row = first; row < last; ++row) work.made[ring_slot(row)] = {0, 0};
    while (first < last && !work.near.any(first)) ++first;
    while (first < last && !work.near.any(last - 1)) --last;
    if (first == last) return;
    std::fill(work.moved.begin(), work.moved.end(), char{0});
    for (Index row = first; row < last; ++row) {
      add_marks(work.moved.data(), work.near.row(row), std::ssize(work.moved));
    }
    if (wanted != nullptr) keep_marks(work.moved.data(), wanted, std::ssize(work.moved));
    gather_runs(work.runs, work.moved.data(), width_);
    if (work.runs.empty()) return;
    if (radius_ > 0) smooth_down(work, image, y, first, last);
    for (Index row = first; row < last; ++row) make_row(work, image, row);
  }

  /// How far row y of the contact is pressed in, 0 where it does not touch or is not known; `out`
  /// has room for whole blocks.
  template <ImageOf<T> D>
  void protrusion(Workspace& work, const D& image, Index y, T* out) const {
    const T* const depth = whole_row_of(image, y, work.buffer.data(), width_);
    vectorised([&] { protrusion_row(out, depth, rest(y), allowed_, whole_width()); });
  }

  /// Row y of the membrane, of which a run is asked and a pixel more on each side, while the band
  /// after the next is not made. The rows before the first and after the last are extrapolated.
  [[nodiscard]] const T* row(Workspace& work, Index y, const Run& run) const {
    if (y >= 0 && y < height_) return made_row(work, y, run);
    const Index first = y < 0 ? 0 : height_ - 1;
    const Index second = std::clamp(y < 0 ? 1 : height_ - 2, Index{0}, height_ - 1);
    T* const outside = ring_row(work, y);
    const T *const edge = made_row(work, first, run), *const before = made_row(work, second, run);
    for (Index x = run.begin - 1; x <= run.end; ++x) outside[x] = beyond_edge(edge[x], before[x]);
    return outside;
  }

  /// Marks the blocks whose normals may differ from those at rest; false where there are none.
  bool mark_changed(const Workspace& work, Index y, Array<char>& changed) const {
    if (has_holes(work, y)) {
      std::fill(changed.begin(), changed.end(), char{1});
      return true;
    }
    if (!work.near.any(y)) return false;
    std::copy_n(work.near.row(y), std::ssize(changed), changed.begin());
    return true;
  }

 private:
  [[nodiscard]] std::ptrdiff_t stride() const { return PaddedRows<T>::stride(width_); }
  [[nodiscard]] std::ptrdiff_t whole_width() const { return whole_blocks(width_); }

  template <class D>
  void keep_rest(const D& image) {
    keep_rest_rows(rest_, masked_, farthest_, image, width_, height_);
    for (Index y = 0; y < height_; ++y) extrapolate_ends(rest_.row(y), width_);
    if (radius_ > 0 && std::any_of(masked_.begin(), masked_.end(), [](char m) { return m != 0; })) {
      Image<T> outside(width_, height_);
      for (Index y = 0; y < height_; ++y) {
        for (Index x = 0; x < width_; ++x) outside(x, y) = is_depth(rest(y)[x]) ? 0 : 1;
      }
      lack_ = convolve_symmetric(outside, weights_, Border::reflect101);
    }
  }

  [[nodiscard]] static std::size_t ring_slot(Index y) {
    return static_cast<std::size_t>((y + 2 * band) % (2 * band));
  }
  [[nodiscard]] T* ring_row(Workspace& work, Index y) const {
    return work.membrane.data() + stride() * static_cast<Index>(ring_slot(y)) + line_size<T>;
  }

  // Where a row of the image is: at rest, or in the ring, which is filled up with what is at rest
  // as far as it is asked for.
  [[nodiscard]] const T* made_row(Workspace& work, Index y, const Run& run) const {
    Run& made = work.made[ring_slot(y)];
    if (made.end == 0) return rest(y);
    T* const z = ring_row(work, y);
    const Run needed{std::min(made.begin, run.begin - 1), std::max(made.end, run.end + 1)};
    std::copy(rest(y) + needed.begin, rest(y) + made.begin, z + needed.begin);
    std::copy(rest(y) + made.end, rest(y) + needed.end, z + made.end);
    made = needed;
    return z;
  }

  // Marks the blocks that the row's protrusion is spread into, and those beside them whose normals
  // that turns; false where there is none.
  [[nodiscard]] bool mark_spread(Workspace& work, const T* protrusion, Index y) const {
    if (work.everything) {
      std::fill(work.spread.begin(), work.spread.end(), char{1});
      return true;
    }
    gather_runs(work.runs, work.touched.data(), width_);
    std::fill(work.spread.begin(), work.spread.end(), char{0});
    for (const Run& run : work.runs) {
      Index first = run.begin, last = run.end - 1;
      while (protrusion[first] == 0) ++first;
      while (protrusion[last] == 0) --last;
      work.near.add(y, first, last, work.spread.data());
    }
    return !work.runs.empty();
  }

  // Smooths the padded row along itself, over the workspace's runs.
  void smooth_along(Workspace& work, T* out) const {
    T* const row = work.padded.data() + whole_lines<T>(radius_);
    const bool at_left = work.runs.front().begin < radius_;
    const bool at_right = work.runs.back().end > width_ - radius_;
    for (Index k = 1; k <= radius_ && (at_left || at_right); ++k) {
      row[-k] = row[inside(-k, width_, Border::reflect101)];
      row[width_ - 1 + k] = row[inside(width_ - 1 + k, width_, Border::reflect101)];
    }
    const T** const taps = work.taps.data() + radius_;
    for (const Run& run : work.runs) {
      for (Index k = -radius_; k <= radius_; ++k) taps[k] = row + run.begin + k;
      vectorised([&] {
        symmetric_sum(out + run.begin, taps, weights_.data(), radius_,
                      std::ptrdiff_t{whole_blocks(run.end - run.begin)});
      });
    }
  }

  void press_holes(Workspace& work, const T* depth, Index y) const {
    if (!vectorised([&] { return row_has_holes(depth, rest(y), whole_width()); })) {
      return work.missing.clear(y);
    }
    work.holes[static_cast<std::size_t>(y)] = 1;
    work.any_holes = true;
    if (radius_ == 0) return;
    T* const row = work.padded.data() + whole_lines<T>(radius_);
    for (Index x = 0; x < width_; ++x) row[x] = is_depth(rest(y)[x]) && !is_known(depth[x]) ? 1 : 0;
    work.runs.assign(1, {0, width_});
    work.missing.set(y, {0, width_}, [&](T* out) { smooth_along(work, out); });
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

  // Smooths down the columns into `sums`, over the workspace's runs in rows `first` to before
  // `last` of the band from row y on: a mean over the known pixels.
  template <class D>
  void smooth_down(Workspace& work, const D& image, Index y, Index first, Index last) const {
    const Index begin = (first - y) / 2 * 2, end = last - y;
    sum_down(work, work.across, y, begin, end, work.sums);
    const bool mask = lack_.width() > 0;
    if (!work.any_holes && !mask) return;
    if (work.any_holes) sum_down(work, work.missing, y, begin, end, work.lack);
    for (Index r = begin; r < end; ++r) {
      auto& sums = work.sums[static_cast<std::size_t>(r)];
      const auto& missing = work.lack[static_cast<std::size_t>(r)];
      for (const Run& run : work.runs) {
        for (Index x = run.begin; x < run.end; ++x) {
          const auto i = static_cast<std::size_t>(x);
          const T lack = (work.any_holes ? missing[i] : 0) + (mask ? lack_(x, y + r) : 0);
          if (!(lack > 0)) continue;
          sums[i] = lack < 1 ? sums[i] / (1 - lack) : 0;
          if (is_hardly_known(lack) && is_depth(rest(y + r)[x])) {
            sums[i] = mean_beside_known(image, x, y + r).value_or(sums[i]);
          }
        }
      }
    }
  }

  template <class D>
  [[nodiscard]] std::optional<T> mean_beside_known(const D& image, Index x, Index y) const {
    const auto value = [&](Index u, Index v) {
      return detail::protrusion(static_cast<T>(ImageTraits<D>::pixel(image, u, v)), rest(v)[u],
                                allowed_);
    };
    return detail::mean_beside_known<T>(value, x, y, width_, height_, weights_);
  }

  // A few columns of all rows of the band at a time, so that they come from the first cache.
  void sum_down(const Workspace& work, const SlidingRows<T>& rows, Index y, Index begin, Index end,
                std::array<Lines<T>, band>& out) const {
    const T* const middle = rows.row(y - radius_) + radius_ * rows.stride();
    for (const Run& run : work.runs) {
      vectorised([&] {
        for (Index x = run.begin; x < run.end; x += column_step) {
          for (Index r = begin; r < end; r += 2) {
            const auto i = static_cast<std::size_t>(r);
            symmetric_sums(out[i].data() + x, out[i + 1].data() + x, middle + r * rows.stride() + x,
                           rows.stride(), weights_.data(), radius_, column_step);
          }
        }
      });
    }
  }

  // Makes row y of the membrane, which is at rest but for the workspace's runs.
  template <class D>
  void make_row(Workspace& work, const D& image, Index y) const {
    T* const z = ring_row(work, y);
    const T* const depth = whole_row_of(image, y, work.buffer.data(), width_);
    const T* const spread = work.sums[static_cast<std::size_t>(y % band)].data();
    Run& made = work.made[ring_slot(y)];
    made = {work.runs[0].begin, work.runs[0].begin};
    for (const Run& run : work.runs) {
      std::copy(rest(y) + made.end, rest(y) + run.begin, z + made.end);
      const std::ptrdiff_t x = run.begin;
      vectorised([&] {
        const std::ptrdiff_t count = whole_blocks(run.end - run.begin);
        if (radius_ == 0) {
          contact_row(z + x, depth + x, rest(y) + x, allowed_, count);
        } else {
          bulge_row(z + x, depth + x, rest(y) + x, spread + x, allowed_, count);
        }
      });
      made.end = run.end;
    }
    if (made.begin == 0) z[--made.begin] = width_ > 1 ? beyond_edge(z[0], z[1]) : z[0];
    if (made.end < width_) return;
    z[made.end++] = width_ > 1 ? beyond_edge(z[width_ - 1], z[width_ - 2]) : z[0];
  }

  Index width_, height_, radius_;
  T allowed_;
  std::vector<T> weights_;
  PaddedRows<T> rest_;  // NaN outside the membrane
  Array<char> masked_;
  Array<T> farthest_;
  Image<T> lack_;  // the share of each pixel's Gaussian that lies outside the membrane, if any does
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::MembraneRows<float>;
GELIGHT_ONCE template class detail::MembraneRows<double>;
}  // namespace gelight
#endif
