#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/detail/normal_rows.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/sensor/detail/row_runs.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// contact[i] = depth[i] where that is known and no deeper than the membrane at rest (or than
/// `allowed`), the rest depth elsewhere.
template <class T>
void contact_row(T* __restrict contact, const T* depth, const T* rest, T allowed,
                 std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T z = depth[i] > 0 ? depth[i] : std::numeric_limits<T>::infinity();
    const T most = rest[i] > allowed ? rest[i] : allowed;
    contact[i] = z <= most ? z : rest[i];
  }
}

/// protrusion[i] = rest[i] - contact[i], 0 outside the membrane.
template <class T>
void protrusion_row(T* __restrict protrusion, const T* contact, const T* rest,
                    std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T difference = rest[i] - contact[i];
    protrusion[i] = difference == difference ? difference : 0;
  }
}

/// out[i] = the smaller of contact[i] and rest[i] - spread[i].
template <class T>
void bulge_row(T* __restrict out, const T* contact, const T* rest, const T* spread,
               std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T bulged = rest[i] - spread[i];
    out[i] = contact[i] < bulged ? contact[i] : bulged;
  }
}

/// Whether a row has a depth that is not known where the membrane is.
template <class T>
[[nodiscard]] bool row_has_holes(const T* depth, const T* rest, std::ptrdiff_t count) {
  int holes = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const bool known = (depth[i] > 0) & (depth[i] <= std::numeric_limits<T>::max());
    holes |= static_cast<int>(!known) & static_cast<int>(rest[i] == rest[i]);
  }
  return holes != 0;
}

/// The depth of an elastic membrane under contact, row after row: min(contact, rest - G(rest -
/// contact)), with the Gaussian G along each row as it comes in and then down the columns.
///
/// Where nothing within the Gaussian's reach differs from rest the membrane is exactly at rest, and
/// is not computed.
template <std::floating_point T>
class MembraneRows {
 public:
  /// What changes while the rows of one image go through.
  struct Workspace {
    std::vector<T> depth, contact, spread, lack;  // a row each
    std::vector<T> padded;                        // a row, `radius` more pixels on each side
    std::vector<T> across;    // rows of protrusion, smoothed along: row y at y mod window
    std::vector<T> missing;   // rows of 1 where the depth is not known, smoothed along, likewise
    std::vector<T> membrane;  // rows of depth, a pixel more on each side: row y at y mod 3
    std::array<const T*, 3> rows{};  // where those rows are: there, or at rest
    std::array<std::vector<char>, 3>
        moved;                  // of each block of those rows: whether it is not at rest
    std::vector<char> touched;  // of each block of a row
    std::vector<Index> newest;  // of each block: the last row that spreads into it
    std::vector<char> used;     // of each row of `across`: whether it is not all zero
    std::vector<char> holes;    // of each row: whether it has unknown depths
    std::vector<const T*> taps;
    std::vector<Run> runs;
    bool everything = false;
  };

  template <ImageOf<T> D>
  MembraneRows(const D& rest, Index width, Index height, std::vector<T> weights, bool clip)
      : width_(width),
        height_(height),
        radius_(static_cast<Index>(weights.size()) - 1),
        window_(2 * radius_ + 1),
        allowed_(clip ? T(0) : std::numeric_limits<T>::max()),
        weights_(std::move(weights)),
        zeros_(static_cast<std::size_t>(width)),
        rest_(static_cast<std::size_t>(stride() * (height + 2))),
        masked_(static_cast<std::size_t>(height)) {
    keep_rest(rest);
  }

  /// How many rows below a row of the membrane are needed to make it.
  [[nodiscard]] Index radius() const { return radius_; }
  [[nodiscard]] const T* rest(Index y) const { return rest_.data() + stride() * (y + 1) + 1; }

  /// Whether a row has pixels outside the membrane.
  [[nodiscard]] bool is_masked(Index y) const { return masked_[static_cast<std::size_t>(y)] != 0; }
  [[nodiscard]] bool has_holes(const Workspace& work, Index y) const {
    return work.holes[static_cast<std::size_t>(y)] != 0;
  }

  [[nodiscard]] Workspace make_workspace() const {
    const auto width = static_cast<std::size_t>(width_), window = static_cast<std::size_t>(window_);
    const auto blocks = static_cast<std::size_t>(block_count(width_));
    Workspace work;
    for (auto* row : {&work.depth, &work.contact, &work.spread, &work.lack}) row->resize(width);
    work.padded.resize(width + window - 1);
    work.across.resize(width * window);
    work.missing.resize(width * window);
    work.membrane.resize(3 * (width + 2));
    for (auto& marks : work.moved) marks.resize(blocks);
    work.touched.resize(blocks);
    work.newest.resize(blocks);
    work.used.resize(window);
    work.holes.resize(static_cast<std::size_t>(height_));
    work.taps.resize(window);
    work.runs.reserve(blocks);
    return work;
  }

  /// Forgets the last image; `everything` computes also what is at rest.
  void start(Workspace& work, bool everything) const {
    work.everything = everything;
    std::fill(work.newest.begin(), work.newest.end(), -1 - window_);
    std::fill(work.across.begin(), work.across.end(), T(0));
    std::fill(work.used.begin(), work.used.end(), char{0});
    std::fill(work.holes.begin(), work.holes.end(), char{0});
  }

  /// Takes in row y of the contact's depth, after row y - 1.
  template <ImageOf<T> D>
  void press(Workspace& work, const D& depth, Index y) const {
    read_contact(work, depth, y);
    if (row_has_holes(work.depth.data(), rest(y), width_)) press_holes(work, y);
    T* const out = across(work.across, y);
    char& used = work.used[static_cast<std::size_t>(y % window_)];
    if (used != 0) std::fill_n(out, width_, T(0));
    used = 0;
    if (!mark_touched(work, y)) return;
    used = 1;
    for (std::size_t b = 0; b < work.touched.size(); ++b) {
      if (work.touched[b] != 0) work.newest[b] = y;
    }
    if (radius_ == 0) return;
    protrusion_row(work.padded.data() + radius_, work.contact.data(), rest(y), width_);
    gather_runs(work.runs, work.touched, width_);
    smooth_along(work, out);
  }

  /// Makes row y of the membrane, once row y + radius (or the last one) is in.
  template <ImageOf<T> D>
  void bulge(Workspace& work, const D& depth, Index y) const {
    auto& moved = work.moved[static_cast<std::size_t>(y % 3)];
    bool any = false;
    for (std::size_t b = 0; b < moved.size(); ++b) {
      moved[b] = work.newest[b] >= y - radius_;
      any = any || moved[b] != 0;
    }
    const T* const at_rest = rest(y);
    work.rows[static_cast<std::size_t>(y % 3)] = at_rest;
    if (!any) return;

    T* const z = work.membrane.data() + stride() * (y % 3) + 1;
    work.rows[static_cast<std::size_t>(y % 3)] = z;
    std::copy_n(at_rest, width_, z);
    gather_runs(work.runs, moved, width_);
    if (radius_ > 0) smooth_down(work, y);
    read_contact(work, depth, y);
    for (const Run& run : work.runs) {
      const std::ptrdiff_t x = run.begin;
      bulge_row(z + x, work.contact.data() + x, at_rest + x, work.spread.data() + x,
                run.end - run.begin);
    }
    extrapolate_ends(z, width_);
  }

  /// How far row y of the contact is pressed in, 0 where it does not touch or is not known.
  template <ImageOf<T> D>
  void protrusion(Workspace& work, const D& depth, Index y, T* out) const {
    read_contact(work, depth, y);
    protrusion_row(out, work.contact.data(), rest(y), width_);
  }

  /// Row y of the membrane, a pixel more on each side, while row y + 2 is not made. The rows before
  /// the first and after the last are extrapolated.
  [[nodiscard]] const T* row(Workspace& work, Index y) const {
    const auto slot = [](Index i) { return static_cast<std::size_t>((i + 3) % 3); };
    if (y >= 0 && y < height_) return work.rows[slot(y)];
    const Index first = y < 0 ? 0 : height_ - 1;
    const Index second = std::clamp(y < 0 ? 1 : height_ - 2, Index{0}, height_ - 1);
    T* const outside = work.membrane.data() + stride() * static_cast<Index>(slot(y)) + 1;
    extrapolate_row(outside, work.rows[slot(first)], work.rows[slot(second)], width_);
    return outside;
  }

  /// Marks the blocks whose normals may differ from those at rest.
  void mark_changed(const Workspace& work, Index y, std::vector<char>& changed) const {
    const std::size_t blocks = changed.size();
    std::fill(changed.begin(), changed.end(), static_cast<char>(has_holes(work, y)));
    for (Index near = std::max(Index{0}, y - 1); near <= std::min(height_ - 1, y + 1); ++near) {
      const auto& moved = work.moved[static_cast<std::size_t>(near % 3)];
      for (std::size_t b = 0; b < blocks; ++b) {
        if (moved[b] == 0) continue;
        changed[b] = 1;
        if (b > 0) changed[b - 1] = 1;
        if (b + 1 < blocks) changed[b + 1] = 1;
      }
    }
  }

 private:
  [[nodiscard]] std::ptrdiff_t stride() const { return std::ptrdiff_t{width_} + 2; }
  [[nodiscard]] T* across(std::vector<T>& rows, Index y) const {
    return rows.data() + std::ptrdiff_t{y % window_} * width_;
  }

  template <class D>
  void keep_rest(const D& image) {
    const auto row = [&](Index y) { return rest_.data() + stride() * (y + 1) + 1; };
    for (Index y = 0; y < height_; ++y) {
      read_row(image, y, row(y), width_);
      for (Index x = 0; x < width_; ++x) {
        if (is_depth(row(y)[x])) continue;
        row(y)[x] = std::numeric_limits<T>::quiet_NaN();
        masked_[static_cast<std::size_t>(y)] = 1;
      }
      extrapolate_ends(row(y), width_);
    }
    if (radius_ > 0 && std::any_of(masked_.begin(), masked_.end(), [](char m) { return m != 0; })) {
      Image<T> outside(width_, height_);
      for (Index y = 0; y < height_; ++y) {
        for (Index x = 0; x < width_; ++x) outside(x, y) = is_depth(row(y)[x]) ? 0 : 1;
      }
      lack_ = convolve_symmetric(outside, weights_, Border::reflect101);
    }
  }

  template <class D>
  void read_contact(Workspace& work, const D& depth, Index y) const {
    read_row(depth, y, work.depth.data(), width_);
    contact_row(work.contact.data(), work.depth.data(), rest(y), allowed_, width_);
  }

  // Marks the blocks that the row's protrusion is spread into; false where there is none.
  [[nodiscard]] bool mark_touched(Workspace& work, Index y) const {
    auto& touched = work.touched;
    if (work.everything) {
      std::fill(touched.begin(), touched.end(), char{1});
      return true;
    }
    const T *const contact = work.contact.data(), *const at_rest = rest(y);
    const auto bytes = static_cast<std::size_t>(width_) * sizeof(T);
    if (std::memcmp(contact, at_rest, bytes) == 0) return false;
    std::fill(touched.begin(), touched.end(), char{0});
    const Index blocks = block_count(width_), reach = (radius_ + block_size - 1) / block_size;
    for (Index b = 0; b < blocks; ++b) {
      const Index begin = b * block_size, end = std::min(width_, begin + block_size);
      const auto size = static_cast<std::size_t>(end - begin) * sizeof(T);
      if (std::memcmp(contact + begin, at_rest + begin, size) == 0) continue;
      const Index first = std::max(Index{0}, b - reach), last = std::min(blocks - 1, b + reach);
      std::fill(touched.begin() + first, touched.begin() + last + 1, char{1});
    }
    return true;
  }

  // Smooths the padded row along itself, over the workspace's runs.
  void smooth_along(Workspace& work, T* out) const {
    T* const row = work.padded.data() + radius_;
    for (Index k = 1; k <= radius_; ++k) {
      row[-k] = row[inside(-k, width_, Border::reflect101)];
      row[width_ - 1 + k] = row[inside(width_ - 1 + k, width_, Border::reflect101)];
    }
    const T** const taps = work.taps.data() + radius_;
    for (const Run& run : work.runs) {
      for (Index k = -radius_; k <= radius_; ++k) taps[k] = row + run.begin + k;
      symmetric_sum(out + run.begin, taps, weights_.data(), radius_, run.end - run.begin);
    }
  }

  void press_holes(Workspace& work, Index y) const {
    if (std::none_of(work.holes.begin(), work.holes.end(), [](char h) { return h != 0; })) {
      std::fill(work.missing.begin(), work.missing.end(), T(0));
    }
    work.holes[static_cast<std::size_t>(y)] = 1;
    if (radius_ == 0) return;
    T* const row = work.padded.data() + radius_;
    for (Index x = 0; x < width_; ++x) {
      row[x] = is_depth(rest(y)[x]) && !is_depth(work.depth[static_cast<std::size_t>(x)]) ? 1 : 0;
    }
    work.runs.assign(1, {0, width_});
    smooth_along(work, across(work.missing, y));
  }

  // Smooths down the columns into `spread`, over the workspace's runs: a mean over the known
  // pixels.
  void smooth_down(Workspace& work, Index y) const {
    sum_down(work, work.across, y, work.spread, false);
    const bool holes = has_holes_near(work, y), mask = lack_.width() > 0;
    if (!holes && !mask) return;
    if (holes) sum_down(work, work.missing, y, work.lack, true);
    for (const Run& run : work.runs) {
      for (Index x = run.begin; x < run.end; ++x) {
        const auto i = static_cast<std::size_t>(x);
        const T lack = (holes ? work.lack[i] : 0) + (mask ? lack_(x, y) : 0);
        if (lack > 0) work.spread[i] = lack < 1 ? work.spread[i] / (1 - lack) : 0;
      }
    }
  }

  [[nodiscard]] bool has_holes_near(const Workspace& work, Index y) const {
    const auto first = work.holes.begin() + std::max(Index{0}, y - radius_);
    const auto end = work.holes.begin() + std::min(height_, y + radius_ + 1);
    return std::any_of(first, end, [](char h) { return h != 0; });
  }

  // `missing` holds only the rows with holes.
  void sum_down(Workspace& work, std::vector<T>& rows, Index y, std::vector<T>& out,
                bool only_holes) const {
    const T** const taps = work.taps.data() + radius_;
    for (const Run& run : work.runs) {
      for (Index k = -radius_; k <= radius_; ++k) {
        const Index from = inside(y + k, height_, Border::reflect101);
        const bool zero = only_holes && !has_holes(work, from);
        taps[k] = (zero ? zeros_.data() : across(rows, from)) + run.begin;
      }
      symmetric_sum(out.data() + run.begin, taps, weights_.data(), radius_, run.end - run.begin);
    }
  }

  Index width_, height_, radius_, window_;
  T allowed_;
  std::vector<T> weights_, zeros_;
  std::vector<T> rest_;  // NaN outside the membrane; a pixel more on each side
  std::vector<char> masked_;
  Image<T> lack_;  // the share of each pixel's Gaussian that lies outside the membrane, if any does
};

}  // namespace gelight::detail
