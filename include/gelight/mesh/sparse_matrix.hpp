#pragma once

#include <algorithm>
#include <complex>
#include <concepts>
#include <memory>
#include <numeric>
#include <type_traits>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/intrinsic.hpp"

namespace gelight {

/// Where a symmetric matrix over the vertices of a triangulation may differ from zero: its lower
/// triangle in compressed columns, diagonal first. Made by counting, in linear time.
template <std::floating_point Real>
class SymmetricPattern {
 public:
  /// That of a matrix with an entry for each vertex and each edge.
  explicit SymmetricPattern(const IntrinsicTriangulation<Real>& mesh) {
    const Index halfedges = static_cast<Index>(mesh.origins.size());
    const auto ends = [&](Index h) -> std::pair<Index, Index> {
      return std::minmax(mesh.origins[h], mesh.origins[h % 3 == 2 ? h - 2 : h + 1]);
    };
    const auto count = static_cast<std::size_t>(mesh.vertex_count);
    begin_.assign(count + 1, 1);
    begin_[0] = 0;
    detail::Array<Index> with_high(count + 1, 0);  // where edges begin by their higher vertex
    // An edge of two faces is looked at once; others may come up repeatedly.
    const auto is_second = [&](Index h) { return mesh.twins[h] >= 0 && mesh.twins[h] < h; };
    for (Index h = 0; h < halfedges; ++h) {
      if (is_second(h)) continue;
      const auto [low, high] = ends(h);
      ++begin_[low + 1];
      ++with_high[high + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::partial_sum(with_high.begin(), with_high.end(), with_high.begin());
    detail::Array<Index> edges;
    edges.resize_for_writes(static_cast<std::size_t>(with_high.back()));
    {
      detail::Array<Index> next(with_high.begin(), with_high.end() - 1);
      for (Index h = 0; h < halfedges; ++h) {
        if (!is_second(h)) edges[next[ends(h).second]++] = h;
      }
    }
    rows_.resize_for_writes(static_cast<std::size_t>(begin_.back()));
    detail::Array<Index> end(begin_.begin(), begin_.end() - 1);  // of each column, so far
    for (Index v = 0; v < mesh.vertex_count; ++v) rows_[end[v]++] = v;
    // In the order of their rows, no column has to be sorted, and what comes up again is last.
    slots_.resize_for_writes(mesh.origins.size());
    for (Index high = 0; high < mesh.vertex_count; ++high) {
      for (Index e = with_high[high]; e < with_high[high + 1]; ++e) {
        Index& place = end[ends(edges[e]).first];
        if (rows_[place - 1] != high) rows_[place++] = high;
        slots_[edges[e]] = place - 1;
      }
    }
    close_gaps(end, [&](Index h) { return is_second(h) ? -1 : ends(h).first; });
    for (Index h = 0; h < halfedges; ++h) {
      if (is_second(h)) slots_[h] = slots_[mesh.twins[h]];
    }
  }

  /// How many columns there are, and rows.
  [[nodiscard]] Index size() const { return static_cast<Index>(begin_.size()) - 1; }
  /// How many entries the lower triangle has.
  [[nodiscard]] Index entry_count() const { return begin_.back(); }
  /// Where the entries of a column begin; those of column `size()` are the end.
  [[nodiscard]] Index begin(Index column) const { return begin_[column]; }
  /// The row of an entry; they ascend within a column.
  [[nodiscard]] Index row(Index entry) const { return rows_[entry]; }
  /// The entry of a vertex with itself.
  [[nodiscard]] Index diagonal(Index vertex) const { return begin_[vertex]; }
  /// The entry of a half-edge's two vertices.
  [[nodiscard]] Index entry(Index halfedge) const { return slots_[halfedge]; }
  /// Where each column begins, and the end: size() + 1 numbers.
  [[nodiscard]] const Index* begins() const { return begin_.data(); }
  /// The rows of all entries.
  [[nodiscard]] const Index* rows() const { return rows_.data(); }

 private:
  // Behind the columns that end before the next one begins, as where edges came up again.
  // `column_of` tells that of a half-edge's slot, or -1 where it has none yet.
  void close_gaps(const detail::Array<Index>& end, const auto& column_of) {
    if (std::equal(end.begin(), end.end(), begin_.begin() + 1)) return;
    detail::Array<Index> shift(end.size());
    Index kept = 0;
    for (Index v = 0; v < size(); ++v) {
      const Index begin = std::exchange(begin_[v], kept);
      shift[v] = begin - kept;
      kept = static_cast<Index>(
          std::copy(rows_.begin() + begin, rows_.begin() + end[v], rows_.begin() + kept) -
          rows_.begin());
    }
    begin_.back() = kept;
    rows_.resize(static_cast<std::size_t>(kept));
    for (Index h = 0; h < std::ssize(slots_); ++h) {
      if (const Index column = column_of(h); column >= 0) slots_[h] -= shift[column];
    }
  }

  detail::Array<Index> begin_;
  detail::Array<Index> rows_;
  detail::Array<Index> slots_;
};

/// A symmetric matrix (Hermitian for complex scalars): entry e of the pattern holds
/// A(row(e), column).
template <class Scalar>
struct SymmetricMatrix {
  /// The real numbers that the scalars are made of.
  using Real = typename Eigen::NumTraits<Scalar>::Real;

  std::shared_ptr<const SymmetricPattern<Real>> pattern;  ///< where its entries are
  detail::Array<Scalar> values;                           ///< of each entry

  /// The product with a vector of size() scalars.
  [[nodiscard]] detail::Array<Scalar> operator*(const detail::Array<Scalar>& x) const {
    detail::Array<Scalar> y;
    multiply_into(y, x);
    return y;
  }
  /// The same in memory that serves again.
  void multiply_into(detail::Array<Scalar>& y, const detail::Array<Scalar>& x) const {
    y.assign(x.size(), Scalar(0));
    for (Index j = 0; j < pattern->size(); ++j) {
      y[j] += values[pattern->diagonal(j)] * x[j];
      for (Index e = pattern->begin(j) + 1; e < pattern->begin(j + 1); ++e) {
        const Index i = pattern->row(e);
        y[i] += values[e] * x[j];
        if constexpr (std::is_floating_point_v<Scalar>) {
          y[j] += values[e] * x[i];
        } else {
          y[j] += std::conj(values[e]) * x[i];
        }
      }
    }
  }
};

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class SymmetricPattern<double>;
}  // namespace gelight
#endif
