#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <complex>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/mesh/factor/columns.hpp"
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
    const auto value_count = dissection_->value_count();
    values_ = large_array<Scalar>(value_count + Columns<Scalar>::overhang);
    std::fill_n(values_.get() + value_count, Columns<Scalar>::overhang, Scalar(0));
    // What is read beside the triangles and behind them means nothing, but is numbers.
    const auto cleared = [](std::ptrdiff_t count) {
      auto values = large_array<Scalar>(count + Front<Scalar>::overhang);
      std::fill_n(values.get(), count + Front<Scalar>::overhang, Scalar(0));
      return values;
    };
    const auto one_block = cleared(dissection_->largest_block());
    Scalar* const block = one_block.get();
    // What children hand to parents waits here.
    const auto updates = cleared(dissection_->stack_size());
    for (const auto& node : dissection_->nodes()) {
      cancelled.check(done / work, "factoring a matrix");
      done += node.work();
      Scalar* const update = updates.get() + node.update;
      std::fill(block, block + node.block_size(), Scalar(0));
      clear_lower_triangle(update, node.border());
      place(node, matrix, block);
      for (Index c = node.last_child; c >= 0; c = dissection_->nodes()[c].sibling) {
        const auto& child = dissection_->nodes()[c];
        add_child(node, child, updates.get() + child.update, block, update);
      }
      Front<Scalar>{block, node.own(), node.height(), update}.eliminate();
      keep(node, block);
    }
  }

  void solve(std::span<Scalar> b) const override { solve(b, {}); }
  void solve(std::span<Scalar> b, const CancelHook& cancelled) const override {
    const typename Pool<Workspace<Scalar>>::Borrowed borrowed(*workspaces_);
    Workspace<Scalar>& work = *borrowed;
    const auto& order = dissection_->order();
    const Slice<Scalar> values(b);
    work.x.resize(b.size());
    for (Index p = 0; p < dissection_->size(); ++p) work.x[p] = values[order[p]];
    solve_lower(work, cancelled.part(0, 0.5));
    solve_upper(work, cancelled.part(0.5, 1));
    for (Index p = 0; p < dissection_->size(); ++p) values[order[p]] = work.x[p];
  }
  void solve_each(std::span<const std::span<Scalar>> sides,
                  const CancelHook& cancelled = {}) const override {
    std::size_t done = 0;
    const auto part = [&](std::size_t count) {
      const auto share = 1 / static_cast<double>(sides.size());
      return cancelled.part(share * static_cast<double>(done),
                            share * static_cast<double>(done + count));
    };
    if constexpr (has_lanes && std::same_as<Scalar, double>) {
      constexpr std::size_t fewest = 5;  // that repay idle lanes
      while (sides.size() - done >= fewest) {
        const auto count = std::min(sides.size() - done, std::size_t{lanes});
        solve_at_once(sides.subspan(done, count), part(count));
        done += count;
      }
    }
    for (; done < sides.size(); ++done) solve(sides[done], part(1));
  }

 private:
  using Node = typename Dissection::Node;

  // What the triangular solves of one system, or several, work in.
  template <class Value>
  struct Workspace {
    Array<Value> x;      // in the order of elimination
    Array<Value> front;  // a node's rows
  };

  static void clear_lower_triangle(Scalar* square, Index size) {
    for (Index j = 0; j < size; ++j, square += size) {
      std::fill(square + j, square + size, Scalar(0));
    }
  }

  void place(const Node& node, const SymmetricMatrix<Scalar>& matrix, Scalar* block) const {
    Scalar* column = block;
    for (Index p = node.begin; p < node.end; ++p, column += node.height()) {
      column[p - node.begin] = matrix.values[matrix.pattern->diagonal(dissection_->order()[p])];
      for (const auto& entry : dissection_->placements(p)) {
        const Scalar& value = matrix.values[entry.number()];
        column[entry.row] = entry.is_transposed() ? conjugate(value) : value;
      }
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

  /// What lies above the diagonal of the block is not kept, and pivots as their inverses.
  void keep(const Node& node, const Scalar* block) {
    Scalar* to = values_.get() + node.values;
    const Index own = node.own(), height = node.height();
    for (Index j = 0; j < own; ++j, block += height) {
      const Index first = j / columns_at_once * columns_at_once;
      to[j - first] = 1 / std::real(block[j]);
      std::copy(block + first, block + j, to);
      to = std::copy(block + j + 1, block + height, to + (j + 1 - first));
    }
  }

  // Several systems at once read the factor once.
  static constexpr Index lanes = SystemLanes::count;

  // (A template, so that it is left alone where scalars are complex.)
  template <class Value = SystemLanes>
  void solve_at_once(std::span<const std::span<Scalar>> sides, const CancelHook& cancelled) const {
    const auto& order = dissection_->order();
    // SystemLanes that are left over repeat the first.
    std::array<Slice<Scalar>, lanes> side;
    side.fill(sides.front());
    std::copy(sides.begin(), sides.end(), side.begin());
    const typename Pool<Workspace<Value>>::Borrowed borrowed(*together_);
    Workspace<Value>& work = *borrowed;
    Array<Value>& x = work.x;
    x.resize(order.size());
    for (Index p = 0; p < dissection_->size(); ++p) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        x[p].set(static_cast<Index>(lane), side[lane][order[p]]);
      }
    }
    vectorised([&] { solve_lower(work, cancelled.part(0, 0.5)); });
    vectorised([&] { solve_upper(work, cancelled.part(0.5, 1)); });
    for (Index p = 0; p < dissection_->size(); ++p) {
      for (std::size_t lane = 0; lane < sides.size(); ++lane) {
        side[lane][order[p]] = x[p][static_cast<Index>(lane)];
      }
    }
  }

  // Both gather a node's rows into one piece of memory, and take several columns at a time, so that
  // those rows are read once for all of them. A value is one system's or several systems'.
  template <class Value>
  void solve_lower(Workspace<Value>& work, const CancelHook& cancelled) const {
    const auto& rows = dissection_->rows();
    Array<Value>&x = work.x, &front = work.front;
    front.resize(static_cast<std::size_t>(dissection_->largest_height()) + overhang);
    const auto& nodes = dissection_->nodes();
    for (const Node& node : nodes) {
      const auto number = &node - nodes.data();
      if (number % nodes_between<Value> == 0) ask(cancelled, number);
      const Index own = node.own(), height = node.height();
      Value* const begin = x.data() + node.begin;
      // One source is in few nodes, and reaches only those above them.
      const auto is_reached = reached(begin, begin + own);
      if (is_reached.none()) continue;
      std::copy(begin, begin + own, front.data());
      std::fill(front.data() + own, front.data() + height + overhang, Value{});
      const Scalar* values = values_.get() + node.values;
      for (Index k = 0; k < own; k += columns_at_once) {
        const Columns<Scalar> columns{values, std::min(columns_at_once, own - k), height - k};
        prefetch_values(values - values_.get() + values_ahead, columns.end() - values);
        columns.eliminate(front.data() + k);
        values = columns.end();
      }
      for (Index r = 0; r < own; ++r) set(begin[r], front[r], is_reached);
      for (Index r = own; r < height; ++r) {
        add(x[rows[node.rows_begin + r - own]], front[r], is_reached);
      }
    }
  }

  template <class Value>
  void solve_upper(Workspace<Value>& work, const CancelHook& cancelled) const {
    const auto& rows = dissection_->rows();
    const auto& nodes = dissection_->nodes();
    Array<Value>&x = work.x, &front = work.front;
    front.resize(static_cast<std::size_t>(dissection_->largest_height()) + overhang);
    for (std::size_t i = nodes.size(); i-- > 0;) {
      const auto* const node = nodes.data() + i;
      const auto number = static_cast<std::ptrdiff_t>(nodes.size() - i) - 1;
      if (number % nodes_between<Value> == 0) ask(cancelled, number);
      const Index own = node->own(), height = node->height();
      std::copy(x.data() + node->begin, x.data() + node->end, front.data());
      for (Index r = own; r < height; ++r) front[r] = x[rows[node->rows_begin + r - own]];
      std::fill_n(front.data() + height, overhang, Value{});
      const Scalar* values = values_.get() + node->values + node->value_count();
      for (Index end = own; end > 0;) {
        const Index k = (end - 1) / columns_at_once * columns_at_once, count = end - k;
        values -= std::ptrdiff_t{count} * (height - k);
        prefetch_values(values - values_.get() - values_ahead,
                        std::ptrdiff_t{count} * (height - k));
        Columns<Scalar>{values, count, height - k}.substitute(front.data() + k);
        end = k;
      }
      std::copy(front.data(), front.data() + own, x.data() + node->begin);
    }
  }

  // Has as many values as a block has fetched from `at` on, some blocks before they are read:
  // processors foresee neither blocks that are read from the last to the first nor those of small
  // nodes. (Always inlined: see `prefetch`.)
  [[gnu::always_inline]] void prefetch_values(std::ptrdiff_t at, std::ptrdiff_t count) const {
    const std::ptrdiff_t first = std::clamp<std::ptrdiff_t>(at, 0, dissection_->value_count());
    count = std::min(count, dissection_->value_count() - first);
    prefetch(values_.get() + first, static_cast<std::size_t>(count) * sizeof(Scalar));
  }
  static constexpr std::ptrdiff_t values_ahead = 8192 / sizeof(Scalar);

  static constexpr Index columns_at_once = Columns<Scalar>::most;
  static constexpr Index overhang = Columns<Scalar>::overhang;
  static_assert(columns_at_once == Dissection::columns_together);
  // How often the triangular solves ask: after so many nodes.
  template <class Value>
  static constexpr std::ptrdiff_t nodes_between = 256 / static_cast<std::ptrdiff_t>(sizeof(Value) /
                                                                                    sizeof(Scalar));

  // Which systems have a value that is not zero.
  static std::bitset<1> reached(const Scalar* first, const Scalar* last) {
    const auto is_zero = [](const Scalar& value) { return value == Scalar(0); };
    return std::all_of(first, last, is_zero) ? 0 : 1;
  }
  static std::bitset<lanes> reached(const SystemLanes* first, const SystemLanes* last) {
    std::bitset<lanes> result;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      result[lane] = std::any_of(first, last, [&](const SystemLanes& x) {
        return x[static_cast<Index>(lane)] != Scalar(0);
      });
    }
    return result;
  }
  // For the systems that are reached: others keep even the signs of their zeros.
  static void set(Scalar& to, const Scalar& value, std::bitset<1>) { to = value; }
  static void add(Scalar& to, const Scalar& value, std::bitset<1>) { to += value; }
  static void set(SystemLanes& to, const SystemLanes& value, std::bitset<lanes> is_reached) {
    if (is_reached.all()) {
      to = value;
      return;
    }
    for (Index lane = 0; lane < lanes; ++lane) {
      if (is_reached[static_cast<std::size_t>(lane)]) to.set(lane, value[lane]);
    }
  }
  static void add(SystemLanes& to, const SystemLanes& value, std::bitset<lanes> is_reached) {
    SystemLanes sum = to;
    set(to, sum += value, is_reached);
  }

  void ask(const CancelHook& cancelled, std::ptrdiff_t nodes_done) const {
    cancelled.check(
        static_cast<double>(nodes_done) / static_cast<double>(dissection_->nodes().size()),
        "solving a linear system");
  }

  std::shared_ptr<const Dissection> dissection_;
  LargeArray<Scalar> values_;  // column by column, each node's without what is above its diagonal
  std::shared_ptr<Pool<Workspace<Scalar>>> workspaces_ =
      std::make_shared<Pool<Workspace<Scalar>>>();
  std::shared_ptr<Pool<Workspace<SystemLanes>>> together_ =
      std::make_shared<Pool<Workspace<SystemLanes>>>();
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

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::SparseFactor<double>;
GELIGHT_ONCE template class detail::SparseFactor<std::complex<double>>;
}  // namespace gelight
#endif
