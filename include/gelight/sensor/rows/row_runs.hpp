#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <limits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// Pixels of a row are marked as changed in blocks of this many, a multiple of what processors
/// take at once: so a pixel is computed alike in a run of any length.
inline constexpr Index block_size = 16;

/// Rows are shaded in tiles of so many pixels, whose intermediate results stay in cache.
inline constexpr Index tile_width = 64;

[[nodiscard]] inline Index block_count(Index width) {
  return (width + block_size - 1) / block_size;
}

/// So many pixels, and as many more as fill their last block. Loops over whole blocks have nothing
/// left over for shorter registers, and are half as long to compile; rows that they read and write
/// have room for it.
[[nodiscard]] constexpr Index whole_blocks(Index count) {
  return (count + block_size - 1) / block_size * block_size;
}

/// Consecutive pixels of a row.
struct Run {
  Index begin, end;
};

/// Gathers the marked (1, not 0) blocks of a row into runs; as many as `runs` has capacity for.
inline void gather_runs(Array<Run>& runs, const char* marks, Index width) {
  runs.clear();
  const char* const first = marks;
  const char* const end = first + block_count(width);
  const auto find = [end](const char* from, int mark) {
    const void* const found = std::memchr(from, mark, static_cast<std::size_t>(end - from));
    return found != nullptr ? static_cast<const char*>(found) : end;
  };
  for (const char* at = find(first, 1); at != end; at = find(at, 1)) {
    const auto begin = static_cast<Index>(at - first);
    at = find(at, 0);
    const auto after = static_cast<Index>(at - first);
    runs.push_back({begin * block_size, std::min(width, after * block_size)});
  }
}

/// Marks also what is marked in `more`.
inline void add_marks(char* __restrict marks, const char* more, std::ptrdiff_t count) {
  for (std::ptrdiff_t b = 0; b < count; ++b) marks[b] |= more[b];
}

/// Marks also what is marked in `more`, and its neighbours.
inline void mark_around(char* __restrict marks, const char* more, std::ptrdiff_t count) {
  add_marks(marks, more, count);
  add_marks(marks + 1, more, count - 1);
  add_marks(marks, more + 1, count - 1);
}

/// Takes away the marks that `kept` has not.
inline void keep_marks(char* __restrict marks, const char* kept, std::ptrdiff_t count) {
  for (std::ptrdiff_t b = 0; b < count; ++b) marks[b] &= kept[b];
}

/// Takes a run apart at the edges of the tiles.
template <class Work>
void for_each_tile(const Run& run, const Work& work) {
  for (Index begin = run.begin; begin < run.end;) {
    const Index end = std::min(run.end, (begin / tile_width + 1) * tile_width);
    work(Run{begin, end});
    begin = end;
  }
}

/// Row y of an image: where it lies if its pixels are of type T and side by side, otherwise a
/// converted copy in `buffer`.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] const T* row_of(const I& image, Index y, T* __restrict buffer, Index width) {
  if constexpr (std::convertible_to<const I&, ImageView<const T>>) {
    const ImageView<const T> view = image;
    if (view.rows_are_packed()) return view.row(y);
  }
  for (Index x = 0; x < width; ++x) buffer[x] = static_cast<T>(ImageTraits<I>::pixel(image, x, y));
  return buffer;
}

/// The same in whole blocks: where the last one is not full, a copy too, which ends with what
/// `buffer` ends with.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] const T* whole_row_of(const I& image, Index y, T* buffer, Index width) {
  const T* const row = row_of(image, y, buffer, width);
  if (row == buffer || whole_blocks(width) == width) return row;
  std::copy_n(row, width, buffer);
  return buffer;
}

}  // namespace gelight::detail
