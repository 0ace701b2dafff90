#pragma once

#include <algorithm>
#include <complex>
#include <concepts>
#include <memory>
#include <numeric>
#include <type_traits>
#include <utility>

#include "gelight/core/array.hpp"
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
    begin_.assign(static_cast<std::size_t>(mesh.vertex_count) + 1, 1);
    begin_[0] = 0;
    // An edge of two faces is looked at once; others may come up repeatedly.
    const auto is_second = [&](Index h) { return mesh.twins[h] >= 0 && mesh.twins[h] < h; };
    for (Index h = 0; h < halfedges; ++h) {
      if (!is_second(h)) ++begin_[ends(h).first + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    rows_.resize(static_cast<std::size_t>(begin_.back()));
    detail::Array<Index> fill(begin_.begin(), begin_.end() - 1);
    for (Index v = 0; v < mesh.vertex_count; ++v) rows_[fill[v]++] = v;
    for (Index h = 0; h < halfedges; ++h) {
      if (is_second(h)) continue;
      const auto [low, high] = ends(h);
      rows_[fill[low]++] = high;
    }
    merge_repeated_rows();
    slots_.resize(mesh.origins.size());
    for (Index h = 0; h < halfedges; ++h) {
      if (is_second(h)) {
        slots_[h] = slots_[mesh.twins[h]];
        continue;
      }
      const auto [low, high] = ends(h);
      const auto row =
          std::lower_bound(rows_.begin() + begin_[low], rows_.begin() + begin_[low + 1], high);
      slots_[h] = static_cast<Index>(row - rows_.begin());
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
  void merge_repeated_rows() {
    Index kept = 0;
    for (Index v = 0; v < size(); ++v) {
      const auto first = rows_.begin() + begin_[v];
      const auto last = rows_.begin() + begin_[v + 1];
      std::sort(first, last);
      const auto end = std::unique(first, last);
      std::copy(first, end, rows_.begin() + kept);
      begin_[v] = kept;
      kept += static_cast<Index>(end - first);
    }
    begin_.back() = kept;
    rows_.resize(static_cast<std::size_t>(kept));
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
