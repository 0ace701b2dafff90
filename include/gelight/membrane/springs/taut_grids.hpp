#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"

namespace gelight::detail {

/// The equation u - across (second difference along x) - down (second difference along y) = f on a
/// rectangle of pixels, without slope across its border.
template <class Real>
class TautGrid {
 public:
  TautGrid(Index width, Index height, double across, double down)
      : width_(width),
        height_(height),
        across_(static_cast<Real>(across)),
        down_(static_cast<Real>(down)),
        solved_(static_cast<std::size_t>(width)) {}

  [[nodiscard]] Index width() const { return width_; }
  [[nodiscard]] Index height() const { return height_; }
  [[nodiscard]] std::ptrdiff_t at(Index x, Index y) const { return std::ptrdiff_t{y} * width_ + x; }

  /// Gauss and Seidel's sweep over one colour of a checkerboard, then the other: each pixel is set
  /// to `constrain(index, what solves its equation)`. Returns the largest change.
  template <class Constrain>
  Real sweep(Array<Real>& u, const Array<Real>& wanted, const Constrain& constrain) {
    Real change = 0;
    for (const Index colour : {0, 1}) {
      for (Index y = 0; y < height_; ++y) {
        const Row row = row_of(u, y);
        const std::ptrdiff_t first = at(0, y);
        Real* const here = &u[first];
        const Real* const f = &wanted[first];
        // All pixels at once, which is vectorised, though those of one colour alone are moved.
        vectorised([&] { solve_row(solved_.data(), here, f, row, width_); });
        for (const Index x : {Index{0}, width_ - 1}) {
          const auto [pull, diagonal] = end(row, here, x);
          solved_[x] = (f[x] + pull) / diagonal;
        }
        for (Index x = (y + colour) % 2; x < width_; x += 2) {
          const Real next = constrain(first + x, solved_[x]);
          change = std::max(change, std::abs(next - here[x]));
          here[x] = next;
        }
      }
    }
    return change;
  }

  /// What is missing for the equation to hold.
  void residual(Array<Real>& out, const Array<Real>& u, const Array<Real>& wanted) const {
    for (Index y = 0; y < height_; ++y) {
      const Row row = row_of(u, y);
      const std::ptrdiff_t first = at(0, y);
      vectorised([&] { residual_row(&out[first], &u[first], &wanted[first], row, width_); });
      for (const Index x : {Index{0}, width_ - 1}) {
        const auto [pull, diagonal] = end(row, &u[first], x);
        out[first + x] = wanted[first + x] + pull - diagonal * u[first + x];
      }
    }
  }

 private:
  // The rows above and below one, none of which counts beyond the border; the diagonal within.
  struct Row {
    const Real *above, *below;
    Real across, weight_above, weight_below, diagonal;

    [[nodiscard]] Real pull(const Real* u, Index x) const {
      return across * (u[x - 1] + u[x + 1]) + weight_above * above[x] + weight_below * below[x];
    }
  };

  static void solve_row(Real* __restrict out, const Real* u, const Real* wanted, const Row& row,
                        Index width) {
    const Row r = row;
    const Real inverse = 1 / r.diagonal;
    for (Index x = 1; x < width - 1; ++x) out[x] = inverse * (wanted[x] + r.pull(u, x));
  }

  static void residual_row(Real* __restrict out, const Real* u, const Real* wanted, const Row& row,
                           Index width) {
    const Row r = row;
    for (Index x = 1; x < width - 1; ++x) out[x] = wanted[x] + r.pull(u, x) - r.diagonal * u[x];
  }

  [[nodiscard]] Row row_of(const Array<Real>& u, Index y) const {
    const bool is_first = y == 0, is_last = y == height_ - 1;
    const Real above = is_first ? 0 : down_, below = is_last ? 0 : down_;
    return {&u[at(0, is_first ? y : y - 1)], &u[at(0, is_last ? y : y + 1)], across_, above, below,
            1 + 2 * across_ + above + below};
  }

  // The pull and the diagonal at an end of a row.
  [[nodiscard]] std::array<Real, 2> end(const Row& row, const Real* u, Index x) const {
    Real pull = row.weight_above * row.above[x] + row.weight_below * row.below[x];
    Real diagonal = row.diagonal - 2 * across_;
    for (const Index neighbour : {x - 1, x + 1}) {
      if (neighbour < 0 || neighbour >= width_) continue;
      pull += across_ * u[neighbour];
      diagonal += across_;
    }
    return {pull, diagonal};
  }

  Index width_, height_;
  Real across_, down_;
  Array<Real> solved_;  // a row
};

/// Corrections to the solution of that equation where some pixels are fixed, by a multigrid cycle:
/// float does, since what a correction lacks the next one finds. (Brandt, Multi-level adaptive
/// solutions to boundary-value problems, 1977, doi:10.1090/S0025-5718-1977-0431719-X)
template <class Real>
class TautGrids {
 public:
  TautGrids(Index width, Index height, double across, double down) {
    for (;;) {
      levels_.emplace_back(width, height, across, down);
      // Smaller grids and shorter reaches are solved by a few sweeps.
      if (std::min(width, height) <= 2 || across + down < 0.1) break;
      width = (width + 1) / 2;
      height = (height + 1) / 2;
      across /= 4;
      down /= 4;
    }
  }

  /// Near to the solution for a right hand side, `scale` times `wanted`, that is smooth, and 0
  /// where `fixed` is not.
  [[nodiscard]] const Array<Real>& correction(const Array<double>& wanted, double scale,
                                              const Array<char>& fixed) {
    Level& fine = levels_.front();
    std::transform(wanted.begin(), wanted.end(), fine.wanted.begin(),
                   [&](double value) { return static_cast<Real>(scale * value); });
    if (fixed != fine.fixed) {
      fine.fixed = fixed;
      for (std::size_t l = 1; l < levels_.size(); ++l) coarsen_fixed(levels_[l], levels_[l - 1]);
    }
    cycle(0);
    return fine.u;
  }

 private:
  struct Level {
    Level(Index width, Index height, double across, double down)
        : grid(width, height, across, down) {
      const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
      for (Array<Real>* const values : {&u, &wanted, &left}) values->resize(count);
      fixed.resize(count);
    }

    TautGrid<Real> grid;
    Array<Real> u, wanted, left;
    Array<char> fixed;
  };

  static void smooth(Level& level, int sweeps) {
    for (int i = 0; i < sweeps; ++i) {
      (void)level.grid.sweep(level.u, level.wanted, [&](std::ptrdiff_t at, Real value) {
        return level.fixed[at] != 0 ? Real(0) : value;
      });
    }
  }

  void cycle(std::size_t l) {
    constexpr int sweeps = 2, last_sweeps = 12;
    Level& fine = levels_[l];
    std::fill(fine.u.begin(), fine.u.end(), Real(0));
    if (l + 1 == levels_.size()) return smooth(fine, last_sweeps);
    // The right hand side of the finest grid is smooth.
    if (l > 0) smooth(fine, sweeps);
    if (l > 0) fine.grid.residual(fine.left, fine.u, fine.wanted);
    restrict_residual(levels_[l + 1], fine, l > 0 ? fine.left : fine.wanted);
    cycle(l + 1);
    add_coarse(fine, levels_[l + 1]);
    smooth(fine, l > 0 ? sweeps : 1);
  }

  // A coarse pixel is fixed where half of it is.
  static void coarsen_fixed(Level& coarse, const Level& fine) {
    for_children(coarse, fine, [&](std::ptrdiff_t parent, const auto& children, int count) {
      int fixed = 0;
      for (int i = 0; i < count; ++i) fixed += fine.fixed[children[static_cast<std::size_t>(i)]];
      coarse.fixed[parent] = 2 * fixed >= count ? 1 : 0;
    });
  }

  static void restrict_residual(Level& coarse, const Level& fine, const Array<Real>& left) {
    for_children(coarse, fine, [&](std::ptrdiff_t parent, const auto& children, int count) {
      Real sum = 0;
      for (int i = 0; i < count; ++i) {
        const std::ptrdiff_t child = children[static_cast<std::size_t>(i)];
        sum += fine.fixed[child] != 0 ? 0 : left[child];
      }
      coarse.wanted[parent] = sum / static_cast<Real>(count);
    });
  }

  template <class Work>
  static void for_children(const Level& coarse, const Level& fine, const Work& work) {
    for (Index y = 0; y < coarse.grid.height(); ++y) {
      const bool is_last_row = 2 * y + 1 >= fine.grid.height();
      for (Index x = 0; x < coarse.grid.width(); ++x) {
        const std::ptrdiff_t first = fine.grid.at(2 * x, 2 * y), row = fine.grid.width();
        const bool is_last = 2 * x + 1 >= fine.grid.width();
        std::array<std::ptrdiff_t, 4> children{first};
        int count = 1;
        if (!is_last) children[static_cast<std::size_t>(count++)] = first + 1;
        if (!is_last_row) children[static_cast<std::size_t>(count++)] = first + row;
        if (!is_last && !is_last_row) children[static_cast<std::size_t>(count++)] = first + row + 1;
        work(coarse.grid.at(x, y), children, count);
      }
    }
  }

  // Between the coarse pixels' centres bilinearly: between two rows first.
  static void add_coarse(Level& fine, Level& coarse) {
    const Index last_row = coarse.grid.height() - 1, last = coarse.grid.width() - 1;
    Real* const row = coarse.left.data();
    for (Index y = 0; y < fine.grid.height(); ++y) {
      const Index near = y / 2;
      const Index far = std::clamp(y % 2 == 0 ? near - 1 : near + 1, Index{0}, last_row);
      const Real* const a = &coarse.u[coarse.grid.at(0, near)];
      const Real* const b = &coarse.u[coarse.grid.at(0, far)];
      vectorised([&] {
        for (Index x = 0; x <= last; ++x) row[x] = Real(0.75) * a[x] + Real(0.25) * b[x];
      });
      Real* const u = &fine.u[fine.grid.at(0, y)];
      const char* const fixed = &fine.fixed[fine.grid.at(0, y)];
      for (Index x = 0; x < fine.grid.width(); ++x) {
        const Index c = x / 2, d = std::clamp(c + 2 * (x % 2) - 1, Index{0}, last);
        u[x] += fixed[x] != 0 ? 0 : Real(0.75) * row[c] + Real(0.25) * row[d];
      }
    }
  }

  std::vector<Level> levels_;
};

}  // namespace gelight::detail
