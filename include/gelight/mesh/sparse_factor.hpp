#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/dissection.hpp"
#include "gelight/mesh/factor/front.hpp"
#include "gelight/mesh/factor/large_array.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

namespace gelight::detail {

/// The Cholesky factor L L* of a sparse positive definite matrix (Hermitian for complex scalars),
/// by the multifrontal method (Liu 1992, doi:10.1137/1034004): each node of a dissection is
/// eliminated as a dense block, what it changes outside is handed to its parent.
///
/// Throws std::runtime_error where a pivot is not positive. Asks the hook at each node. May be read
/// by several threads.
template <class Scalar>
class SparseFactor : public LinearFactor<Scalar> {
 public:
  using Dissection = detail::Dissection<typename Eigen::NumTraits<Scalar>::Real>;

  SparseFactor(std::shared_ptr<const Dissection> dissection, const SymmetricMatrix<Scalar>& matrix,
               const CancelHook& cancelled = {})
      : dissection_(std::move(dissection)) {
    double work = 0;
    for (const auto& node : dissection_->nodes()) work += node.work();
    double done = 0;
    values_ = large_array<Scalar>(dissection_->value_count());
    const auto one_block =
        large_array<Scalar>(dissection_->largest_block() + Front<Scalar>::overhang);
    Scalar* const block = one_block.get();
    // What children hand to parents waits here.
    const auto updates = large_array<Scalar>(dissection_->stack_size() + Front<Scalar>::overhang);
    for (const auto& node : dissection_->nodes()) {
      cancelled.check(done / work, "factoring a matrix");
      done += node.work();
      Scalar* const update = updates.get() + node.update;
      std::fill(block, block + node.block_size(), Scalar(0));
      clear_lower_triangle(update, node.border());
      for (Index i = node.placements_begin; i < node.placements_end; ++i) {
        const auto& [entry, is_transposed, slot] = dissection_->placements()[i];
        block[slot] = is_transposed ? conjugate(matrix.values[entry]) : matrix.values[entry];
      }
      for (const std::size_t c : {1U, 0U}) {
        if (node.children[c] < 0) continue;
        const auto& child = dissection_->nodes()[node.children[c]];
        add_child(node, child, updates.get() + child.update, block, update);
      }
      Front<Scalar>(block, node.own(), node.height(), update).eliminate();
      keep(node, block);
    }
  }

  void solve(std::span<Scalar> b) const override { solve(b, {}); }
  void solve(std::span<Scalar> b, const CancelHook& cancelled) const override {
    const auto& order = dissection_->order();
    const Slice<Scalar> values(b);
    Array<Scalar> x(b.size());
    for (Index p = 0; p < dissection_->size(); ++p) x[p] = values[order[p]];
    solve_lower(x, cancelled.part(0, 0.5));
    solve_upper(x, cancelled.part(0.5, 1));
    for (Index p = 0; p < dissection_->size(); ++p) values[order[p]] = x[p];
  }

 private:
  using Node = typename Dissection::Node;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  static void clear_lower_triangle(Scalar* square, Index size) {
    for (Index j = 0; j < size; ++j, square += size) {
      std::fill(square + j, square + size, Scalar(0));
    }
  }

  void add_child(const Node& node, const Node& child, const Scalar* from, Scalar* block,
                 Scalar* update) const {
    const Index* rows = dissection_->rows_in_parent().data() + child.rows_begin;
    const Index own = node.own(), height = node.height();
    const Index border = child.border();
    for (Index j = 0; j < border; ++j, from += border) {
      Scalar* const to = rows[j] < own
                             ? block + std::ptrdiff_t{rows[j]} * height
                             : update + std::ptrdiff_t{rows[j] - own} * node.border() - own;
      for (Index i = j; i < border; ++i) to[rows[i]] += from[i];
    }
  }

  /// What lies above the diagonal of the block is not kept.
  void keep(const Node& node, const Scalar* block) {
    Scalar* to = values_.get() + node.values;
    const Index own = node.own(), height = node.height();
    for (Index j = 0; j < own; ++j, block += height) {
      to = std::copy(block + j / columns_at_once * columns_at_once, block + height, to);
    }
  }

  // How often the triangular solves ask: after so many nodes.
  static constexpr std::ptrdiff_t nodes_between = 256;

  // Both gather a node's rows into one piece of memory, and take several columns at a time, so that
  // those rows are read once for all of them.
  void solve_lower(Array<Scalar>& x, const CancelHook& cancelled) const {
    const auto& rows = dissection_->rows();
    Array<Scalar> front(static_cast<std::size_t>(dissection_->largest_height()));
    const auto& nodes = dissection_->nodes();
    for (const Node& node : nodes) {
      const auto number = &node - nodes.data();
      if (number % nodes_between == 0) ask(cancelled, number);
      const Index own = node.own(), height = node.height();
      const Scalar* const begin = x.data() + node.begin;
      // One source is in few nodes, and reaches only those above them.
      const auto is_zero = [](const Scalar& value) { return value == Scalar(0); };
      if (std::all_of(begin, begin + own, is_zero)) continue;
      std::copy(begin, begin + own, front.data());
      std::fill(front.data() + own, front.data() + height, Scalar(0));
      const Scalar* values = values_.get() + node.values;
      for (Index k = 0; k < own; k += columns_at_once) {
        const Columns columns{values, std::min(columns_at_once, own - k), height - k};
        eliminate(columns, front.data() + k);
        values = columns.end();
      }
      std::copy(front.data(), front.data() + own, x.data() + node.begin);
      for (Index r = own; r < height; ++r) x[rows[node.rows_begin + r - own]] += front[r];
    }
  }

  void solve_upper(Array<Scalar>& x, const CancelHook& cancelled) const {
    const auto& rows = dissection_->rows();
    const auto& nodes = dissection_->nodes();
    Array<Scalar> front(static_cast<std::size_t>(dissection_->largest_height()));
    for (const auto* node = nodes.end(); node-- != nodes.begin();) {
      const auto number = nodes.end() - node - 1;
      if (number % nodes_between == 0) ask(cancelled, number);
      const Index own = node->own(), height = node->height();
      std::copy(x.data() + node->begin, x.data() + node->end, front.data());
      for (Index r = own; r < height; ++r) front[r] = x[rows[node->rows_begin + r - own]];
      const Scalar* values = values_.get() + node->values + node->value_count();
      for (Index end = own; end > 0;) {
        const Index k = (end - 1) / columns_at_once * columns_at_once, count = end - k;
        values -= std::ptrdiff_t{count} * (height - k);
        substitute({values, count, height - k}, front.data() + k);
        end = k;
      }
      std::copy(front.data(), front.data() + own, x.data() + node->begin);
    }
  }

  using Packet = typename Eigen::internal::packet_traits<Scalar>::type;
  static constexpr Index width = Eigen::internal::unpacket_traits<Packet>::size;
  static constexpr Index columns_at_once = Dissection::columns_together;

  /// A few columns of the factor, from the first one's diagonal on down.
  struct Columns {
    const Scalar* values;
    Index count, rows;

    [[nodiscard]] const Scalar* operator[](Index j) const {
      return values + std::ptrdiff_t{j} * rows;
    }
    [[nodiscard]] const Scalar* end() const { return (*this)[count]; }
  };

  // Solves for the first rows of x, and takes what they are out of those below.
  static void eliminate(const Columns& columns, Scalar* x) {
    for (Index j = 0; j < columns.count; ++j) {
      x[j] /= columns[j][j];
      for (Index i = j + 1; i < columns.count; ++i) x[i] -= x[j] * columns[j][i];
    }
    const Index below = columns.rows - columns.count;
    Eigen::Map<Vector> rest(x + columns.count, below);
    const auto column = [&](Index j) {
      return Eigen::Map<const Vector>(columns[j] + columns.count, below);
    };
    if (columns.count == columns_at_once) {
      rest = rest - x[0] * column(0) - x[1] * column(1) - x[2] * column(2) - x[3] * column(3);
    } else {
      for (Index j = 0; j < columns.count; ++j) rest -= x[j] * column(j);
    }
  }

  // Solves for the first rows of x with those below known.
  static void substitute(const Columns& columns, Scalar* x) {
    const Index below = columns.rows - columns.count;
    if (columns.count == columns_at_once) {
      subtract_dots(columns, x, below);
    } else {
      const Eigen::Map<const Vector> rest(x + columns.count, below);
      for (Index j = 0; j < columns.count; ++j) {
        x[j] -= Eigen::Map<const Vector>(columns[j] + columns.count, below).dot(rest);
      }
    }
    for (Index j = columns.count - 1; j >= 0; --j) {
      for (Index i = j + 1; i < columns.count; ++i) x[j] -= conjugate(columns[j][i]) * x[i];
      x[j] /= columns[j][j];
    }
  }

  // Of all the columns with what lies below them.
  static void subtract_dots(const Columns& columns, Scalar* x, Index below) {
    namespace simd = Eigen::internal;
    const Scalar *const a = columns[0] + columns_at_once, *const b = columns[1] + columns_at_once;
    const Scalar *const c = columns[2] + columns_at_once, *const d = columns[3] + columns_at_once;
    const Scalar* const rest = x + columns_at_once;
    Packet sum_a = simd::pset1<Packet>(Scalar(0)), sum_b = sum_a, sum_c = sum_a, sum_d = sum_a;
    const auto add = [](Packet& sum, const Scalar* column, const Packet& y) {
      sum = simd::pmadd(simd::pconj(simd::ploadu<Packet>(column)), y, sum);
    };
    Index i = 0;
    for (; i + width <= below; i += width) {
      const Packet y = simd::ploadu<Packet>(rest + i);
      add(sum_a, a + i, y);
      add(sum_b, b + i, y);
      add(sum_c, c + i, y);
      add(sum_d, d + i, y);
    }
    x[0] -= simd::predux(sum_a);
    x[1] -= simd::predux(sum_b);
    x[2] -= simd::predux(sum_c);
    x[3] -= simd::predux(sum_d);
    for (; i < below; ++i) {
      x[0] -= conjugate(a[i]) * rest[i];
      x[1] -= conjugate(b[i]) * rest[i];
      x[2] -= conjugate(c[i]) * rest[i];
      x[3] -= conjugate(d[i]) * rest[i];
    }
  }

  void ask(const CancelHook& cancelled, std::ptrdiff_t nodes_done) const {
    cancelled.check(
        static_cast<double>(nodes_done) / static_cast<double>(dissection_->nodes().size()),
        "solving a linear system");
  }

  std::shared_ptr<const Dissection> dissection_;
  LargeArray<Scalar> values_;  // column by column, each node's without what is above its diagonal
};

/// Enlarges a matrix' diagonal until no row's other entries sum to more, but for rounding.
template <class Scalar>
void dominate(SymmetricMatrix<Scalar>& matrix) {
  const auto& pattern = *matrix.pattern;
  Array<double> others(static_cast<std::size_t>(pattern.size()), 0);
  for (Index j = 0; j < pattern.size(); ++j) {
    for (Index e = pattern.begin(j); e < pattern.begin(j + 1); ++e) {
      const Index row = pattern.row(e);
      if (row == j) continue;
      others[j] += std::abs(matrix.values[e]);
      others[row] += std::abs(matrix.values[e]);
    }
  }
  constexpr double above = 1 + 1e-12;
  for (Index j = 0; j < pattern.size(); ++j) {
    Scalar& diagonal = matrix.values[pattern.diagonal(j)];
    diagonal = std::max(std::real(diagonal), above * others[j]);
  }
}

/// `factor(matrix)` of a matrix that is positive definite but for rounding, as those of needles and
/// of edges without length are not: where a pivot fails, the diagonal is first enlarged by the
/// least of 1e-14, 1e-12, ... of itself that helps. Where 1e-4 does not, as in a connection
/// Laplacian of obtuse faces round a sharp cone, it is made diagonally dominant. Throws
/// std::runtime_error where the matrix is not finite.
template <class Scalar>
[[nodiscard]] auto factored(SymmetricMatrix<Scalar> matrix, const auto& factor) {
  for (const double share : {1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4}) {
    try {
      return factor(matrix);
    } catch (const Cancelled&) {
      throw;
    } catch (const std::runtime_error&) {
      // Once more, with a larger diagonal.
    }
    const auto& pattern = *matrix.pattern;
    for (Index v = 0; v < pattern.size(); ++v) matrix.values[pattern.diagonal(v)] *= 1 + share;
  }
  dominate(matrix);
  return factor(matrix);
}

/// The same with our own factor.
template <class Scalar>
[[nodiscard]] SparseFactor<Scalar> factored(
    const std::shared_ptr<const typename SparseFactor<Scalar>::Dissection>& dissection,
    SymmetricMatrix<Scalar> matrix, const CancelHook& cancelled = {}) {
  return factored(std::move(matrix), [&](const SymmetricMatrix<Scalar>& positive) {
    return SparseFactor<Scalar>(dissection, positive, cancelled);
  });
}

}  // namespace gelight::detail
