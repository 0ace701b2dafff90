#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// So many windows are computed at a time. Columns have room for a multiple of it, and what lies
/// between the last window and that multiple may be read and overwritten, but means nothing.
inline constexpr std::ptrdiff_t lane_size = 4;

/// Windows on one half-edge, structure of arrays; a view of memory elsewhere. A window holds the
/// points begin <= p <= end of the edge (in its unit, from the half-edge's origin) that straight
/// lines reach from the image of its origin at (x, y), y < 0, in the half-edge's frame.
template <std::floating_point Real>
struct WindowColumns {
  Real *begin = nullptr, *end = nullptr, *x = nullptr, *y = nullptr;
  Index* origin = nullptr;  // which source or bend of the path the windows come from

  /// Where the columns lie in memory of `words(capacity)` words, each as large as a Real.
  static WindowColumns in(std::byte* memory, std::ptrdiff_t capacity) {
    auto* column = reinterpret_cast<Real*>(memory);
    return {column, column + capacity, column + 2 * capacity, column + 3 * capacity,
            reinterpret_cast<Index*>(column + 4 * capacity)};
  }
  static std::ptrdiff_t words(std::ptrdiff_t capacity) { return 4 * capacity + capacity / 2; }
  static_assert(2 * sizeof(Index) <= sizeof(Real));

  void copy(std::ptrdiff_t to, const WindowColumns& from, std::ptrdiff_t i) const {
    begin[to] = from.begin[i];
    end[to] = from.end[i];
    x[to] = from.x[i];
    y[to] = from.y[i];
    origin[to] = from.origin[i];
  }

  void copy(std::ptrdiff_t to, const WindowColumns& from, std::ptrdiff_t first,
            std::ptrdiff_t count) const {
    std::copy_n(from.begin + first, count, begin + to);
    std::copy_n(from.end + first, count, end + to);
    std::copy_n(from.x + first, count, x + to);
    std::copy_n(from.y + first, count, y + to);
    std::copy_n(from.origin + first, count, origin + to);
  }
};

/// Windows under work, with the distance at each one's origin.
template <std::floating_point Real>
struct WindowList : WindowColumns<Real> {
  using Columns = WindowColumns<Real>;

  Real* start = nullptr;
  std::ptrdiff_t size = 0;

  // A copy's columns would be those of the other.
  WindowList() = default;
  WindowList(WindowList&&) noexcept = default;
  WindowList& operator=(WindowList&&) noexcept = default;
  ~WindowList() = default;

  /// Makes room, keeping the windows.
  void reserve(std::ptrdiff_t capacity) {
    if (capacity <= capacity_) return;
    capacity = static_cast<std::ptrdiff_t>(
        std::bit_ceil(static_cast<std::size_t>(std::max(capacity, lane_size))));
    Array<std::byte> memory(static_cast<std::size_t>(Columns::words(capacity) + capacity) *
                            sizeof(Real));
    const Columns columns = Columns::in(memory.data(), capacity);
    auto* starts = reinterpret_cast<Real*>(memory.data()) + Columns::words(capacity);
    columns.copy(0, *this, 0, size);
    std::copy_n(start, size, starts);
    static_cast<Columns&>(*this) = columns;
    start = starts;
    capacity_ = capacity;
    memory_ = std::move(memory);
  }

  /// Adds windows whose starts are not known; reads and writes whole lanes.
  void append(const Columns& from, std::ptrdiff_t count) {
    constexpr auto lane_bytes = lane_size * sizeof(Real);
    for (std::ptrdiff_t i = 0; i < count; i += lane_size) {
      const std::ptrdiff_t to = size + i;
      std::memcpy(this->begin + to, from.begin + i, lane_bytes);
      std::memcpy(this->end + to, from.end + i, lane_bytes);
      std::memcpy(this->x + to, from.x + i, lane_bytes);
      std::memcpy(this->y + to, from.y + i, lane_bytes);
      std::copy_n(from.origin + i, lane_size, this->origin + to);
    }
    size += count;
  }

  /// Repeats the first window in a lane behind the last one, so that what is computed there is as
  /// well defined as what is meant.
  void fill_lane() {
    for (std::ptrdiff_t i = size; i < size + lane_size; ++i) this->copy(i, *this, 0);
  }

  void move(std::ptrdiff_t to, std::ptrdiff_t i) {
    this->copy(to, *this, i);
    start[to] = start[i];
  }
  /// Several, to the front.
  void move(std::ptrdiff_t to, std::ptrdiff_t first, std::ptrdiff_t count) {
    for (std::ptrdiff_t i = 0; i < count; ++i) move(to + i, first + i);
  }

 private:
  std::ptrdiff_t capacity_ = 0;
  Array<std::byte> memory_;
};

/// The windows that wait on each half-edge: batches, each contiguous, in memory that is used again.
template <std::floating_point Real>
class WindowStore {
 public:
  using Columns = WindowColumns<Real>;
  using List = WindowList<Real>;

  /// Room for a batch: its columns, and a handle to add or release it by.
  struct Batch {
    Columns windows;
    std::uint32_t handle;
  };

  /// Empties the store; in time proportional to what was used of it, where that was little.
  void reset(Index halfedges) {
    if (std::ssize(first_) == halfedges && std::ssize(touched_) < touched_limit()) {
      for (const Index h : touched_) first_[h] = none;
    } else {
      first_.assign(static_cast<std::size_t>(halfedges), none);
    }
    touched_.clear();
    free_.fill(none);
    used_slabs_ = 0;
    used_bytes_ = 0;
    slab_fill_ = slab_words;
  }

  /// Memory in use, in bytes.
  [[nodiscard]] std::size_t bytes() const { return used_bytes_; }

  [[nodiscard]] bool empty(Index h) const { return first_[h] == none; }

  /// Has the processor fetch what tells whether windows wait on a half-edge; or the first of them.
  /// (Always inlined, as prefetch.)
  ///@{
  [[gnu::always_inline]] void expect(Index h) const { prefetch(&first_[h], sizeof first_[h]); }
  [[gnu::always_inline]] void expect_windows(Index h) const {
    if (first_[h] != none) prefetch(memory_of(first_[h]), expected_bytes);
  }
  ///@}

  [[nodiscard]] Batch allocate(std::ptrdiff_t capacity) {
    const auto size_class = static_cast<std::size_t>(
        std::bit_width(static_cast<std::size_t>(std::max(capacity, lane_size) - 1)));
    const std::uint32_t handle =
        free_[size_class] != none ? take_free(size_class) : take_new(size_class);
    Header& header = header_of(handle);
    header.size_class = static_cast<std::uint16_t>(size_class);
    return {columns_of(handle), handle};
  }

  void release(const Batch& batch) { release(batch.handle); }

  /// Adds a batch of `count` windows to a half-edge, before the first batch that lies farther on.
  void add(Index h, const Batch& batch, std::ptrdiff_t count) {
    header_of(batch.handle).count = static_cast<Index>(count);
    std::uint32_t* link = &first_[h];
    if (*link == none && std::ssize(touched_) < touched_limit()) touched_.push_back(h);
    while (*link != none && columns_of(*link).begin[0] < batch.windows.begin[0]) {
      link = &header_of(*link).next;
    }
    header_of(batch.handle).next = *link;
    *link = batch.handle;
  }

  /// Calls visit(columns, count) for each batch on a half-edge.
  template <class Visit>
  void for_each(Index h, const Visit& visit) const {
    for (std::uint32_t b = first_[h]; b != none; b = header_of(b).next) {
      visit(columns_of(b), std::ptrdiff_t{header_of(b).count});
    }
  }

  /// Moves all windows on a half-edge into a list, batches merged by the windows' middles, with
  /// room for one lane behind them. Their starts are not known here.
  void take_all(Index h, List& list) {
    list.size = 0;
    for (std::uint32_t b = first_[h]; b != none;) {
      const Header header = header_of(b);
      list.reserve(list.size + header.count + lane_size);
      const Columns batch = columns_of(b);
      if (list.size == 0 || !(middle(batch, 0) < middle(list, list.size - 1))) {
        list.append(batch, header.count);
      } else {
        merge(list, batch, header.count);
      }
      release(b);
      b = header.next;
    }
    first_[h] = none;
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  // Slabs of 1 MB; a larger batch has slabs of its own. Handles count words.
  static constexpr std::ptrdiff_t slab_words = std::ptrdiff_t{1} << 17;
  static constexpr std::size_t word = sizeof(Real);
  // What is fetched of a batch: all, where it has up to eight windows.
  static constexpr std::size_t expected_bytes = 320;

  [[nodiscard]] std::ptrdiff_t touched_limit() const { return std::ssize(first_) / 16 + 1; }

  static Real middle(const Columns& windows, std::ptrdiff_t i) {
    return windows.begin[i] + windows.end[i];
  }

  // From the last one down, so that only windows behind the batch's first one move.
  static void merge(List& list, const Columns& batch, std::ptrdiff_t count) {
    std::ptrdiff_t i = list.size - 1, j = count - 1;
    list.size += count;
    for (std::ptrdiff_t k = list.size - 1; j >= 0; --k) {
      if (i >= 0 && middle(list, i) > middle(batch, j)) {
        list.copy(k, list, i--);
      } else {
        list.copy(k, batch, j--);
      }
    }
  }

  struct Header {
    std::uint32_t next;
    Index count;
    std::uint16_t size_class;
  };
  static constexpr std::ptrdiff_t header_words = 2;
  static_assert(sizeof(Header) <= header_words * word);

  [[nodiscard]] std::byte* memory_of(std::uint32_t handle) const {
    return slabs_[handle / slab_words].begin + handle % slab_words * word;
  }
  [[nodiscard]] Header& header_of(std::uint32_t handle) const {
    return *reinterpret_cast<Header*>(memory_of(handle));
  }
  [[nodiscard]] Columns columns_of(std::uint32_t handle) const {
    return Columns::in(memory_of(handle) + header_words * word,
                       std::ptrdiff_t{1} << header_of(handle).size_class);
  }
  static std::ptrdiff_t words_of(std::size_t size_class) {
    return header_words + Columns::words(std::ptrdiff_t{1} << size_class);
  }

  void release(std::uint32_t handle) {
    std::uint32_t& free = free_[header_of(handle).size_class];
    header_of(handle).next = free;
    free = handle;
  }

  std::uint32_t take_free(std::size_t size_class) {
    const std::uint32_t handle = free_[size_class];
    free_[size_class] = header_of(handle).next;
    return handle;
  }

  std::uint32_t take_new(std::size_t size_class) {
    const std::ptrdiff_t words = words_of(size_class);
    if (slab_fill_ + words > slab_words) {
      add_slab(words);
      slab_fill_ = 0;
    }
    const auto handle = static_cast<std::uint32_t>((used_slabs_ - 1) * slab_words + slab_fill_);
    slab_fill_ += words;
    return handle;
  }

  struct Slab {
    Array<std::byte> memory;
    std::byte* begin = nullptr;  // of it

    Slab() = default;
    Slab(Slab&&) noexcept = default;
    Slab& operator=(Slab&&) noexcept = default;
    ~Slab() = default;
  };

  void add_slab(std::ptrdiff_t words) {
    const std::size_t size = static_cast<std::size_t>(std::max(words, slab_words)) * word;
    if (used_slabs_ == std::ssize(slabs_)) slabs_.emplace_back();
    Slab& slab = slabs_[used_slabs_++];
    if (slab.memory.size() < size) {
      // Of the first slab short solves touch little; who needs a second one needs most of it.
      if (used_slabs_ > 1) slab.memory.reserve_for_all(size);
      slab.memory.resize_unwritten(size);
      slab.begin = slab.memory.data();
    }
    used_bytes_ += slab.memory.size();
  }

  Array<std::uint32_t> first_;            // of each half-edge: its first batch
  Array<Index> touched_;                  // half-edges that had a batch, up to the limit
  std::array<std::uint32_t, 32> free_{};  // of each size class: a batch that is free
  Array<Slab> slabs_;
  std::ptrdiff_t used_slabs_ = 0, slab_fill_ = slab_words;
  std::size_t used_bytes_ = 0;
};

}  // namespace gelight::detail
