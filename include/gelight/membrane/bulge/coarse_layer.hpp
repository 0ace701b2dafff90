#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/membrane/layer/green.hpp"

// An elastic layer on a coarse grid, and the contact there: no Fourier transform, no allocation.
namespace gelight::detail {

/// A function of |x| and |y| as a sum of products of one function of x and one of y: the singular
/// vectors of the matrix of its values, which no sum of as many products comes nearer to in the
/// mean square.
template <class T>
class SeparableKernel {
 public:
  template <class Value>
  SeparableKernel(Index width, Index height, int terms, const Value& value)
      : width_(width), height_(height) {
    Array<double> rest(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    double square = 0;
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        rest[std::ptrdiff_t{y} * width + x] = value(x, y);
        square += value(x, y) * value(x, y);
      }
    }
    // Smaller terms are rounding.
    for (int k = 0; k < terms && split_off(rest) > 1e-20 * square; ++k) continue;
  }

  [[nodiscard]] std::size_t terms() const { return across_.size(); }
  /// The values at x - source, for all x from 0 on.
  [[nodiscard]] const T* across(std::size_t term, Index source) const {
    return across_[term].data() + (width_ - 1 - source);
  }
  [[nodiscard]] T down(std::size_t term, Index y) const {
    return down_[term][static_cast<std::size_t>(std::abs(y))];
  }

 private:
  // Moves the product of the largest singular value from the matrix to the sum, by power iteration
  // from the column at x = 0, where the function is largest. Returns its squared norm.
  double split_off(Array<double>& rest) {
    constexpr int rounds = 30;
    Array<double> u(static_cast<std::size_t>(width_)), v(static_cast<std::size_t>(height_));
    u[0] = 1;
    double square = 0;
    for (int round = 0; round < rounds; ++round) {
      for (Index y = 0; y < height_; ++y) {
        v[y] = 0;
        for (Index x = 0; x < width_; ++x) v[y] += rest[std::ptrdiff_t{y} * width_ + x] * u[x];
      }
      if (normalise(v) == 0) return 0;
      std::fill(u.begin(), u.end(), 0.0);
      for (Index y = 0; y < height_; ++y) {
        for (Index x = 0; x < width_; ++x) u[x] += rest[std::ptrdiff_t{y} * width_ + x] * v[y];
      }
      square = normalise(u);
    }
    const double size = std::sqrt(square);
    std::vector<T> across, down;
    for (Index x = 1 - width_; x < width_; ++x) {
      across.push_back(static_cast<T>(size * u[std::abs(x)]));
    }
    for (const double value : v) down.push_back(static_cast<T>(value));
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        rest[std::ptrdiff_t{y} * width_ + x] -= size * u[x] * v[y];
      }
    }
    across_.push_back(std::move(across));
    down_.push_back(std::move(down));
    return square;
  }

  // Returns the squared length that it had.
  static double normalise(Array<double>& vector) {
    double square = 0;
    for (const double value : vector) square += value * value;
    for (double& value : vector) value /= square > 0 ? std::sqrt(square) : 1;
    return square;
  }

  Index width_, height_;
  std::vector<std::vector<T>> across_, down_;
};

/// out += a[0] rows[0] + ... + a[3] rows[3].
template <class T>
void add_four_rows(T* __restrict out, const std::array<T, 4>& a,
                   const std::array<const T*, 4>& rows, std::ptrdiff_t count) {
  const T *const r0 = rows[0], *const r1 = rows[1], *const r2 = rows[2], *const r3 = rows[3];
  for (std::ptrdiff_t x = 0; x < count; ++x) {
    out[x] += a[0] * r0[x] + a[1] * r1[x] + a[2] * r2[x] + a[3] * r3[x];
  }
}

/// A rectangle of a coarse grid.
struct Cells {
  Index left = 0, top = 0, width = 0, height = 0;

  [[nodiscard]] std::size_t area() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  /// Of the cell in a column and row of its own.
  [[nodiscard]] std::size_t at(Index x, Index y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// How a layer's surface sinks under pressures, on cells of `step` by `step` pixels: lengths in
/// any unit, pressures in units in which the layer's response is without one.
template <class T>
class CoarseLayer {
 public:
  /// `fine` is the grid of pixels.
  CoarseLayer(const LayerGrid& fine, Index step, int kernels)
      : step_(step),
        width_((fine.width + step - 1) / step),
        height_((fine.height + step - 1) / step),
        kernel_(make(fine, kernels)) {}

  [[nodiscard]] Index step() const { return step_; }
  [[nodiscard]] Index width() const { return width_; }
  [[nodiscard]] Index height() const { return height_; }
  /// How far a cell sinks by a pressure of its own.
  [[nodiscard]] T softness() const { return softness_; }

  /// How far cells sink by the pressures on others. `part` is worked in: the others' rows, as wide
  /// as the first.
  void sink(T* out, const Cells& to, const T* pressure, const Cells& from, T* part) const {
    std::fill_n(out, to.area(), T(0));
    for (std::size_t term = 0; term < kernel_.terms(); ++term) {
      vectorised([&] { along(part, to, pressure, from, term); });
      vectorised([&] { down(out, to, part, from, term); });
    }
  }

 private:
  [[nodiscard]] SeparableKernel<T> make(const LayerGrid& fine, int kernels) {
    const LayerGrid grid{width_, height_, fine.aspect, fine.thickness / step_, fine.poisson_ratio};
    const PressureGreen green(grid, layer_correction(grid));
    softness_ = static_cast<T>(green.down(0, 0));
    return {width_, height_, kernels, [&](Index x, Index y) { return green.down(x, y); }};
  }

  void along(T* part, const Cells& to, const T* pressure, const Cells& from,
             std::size_t term) const {
    for (Index y = 0; y < from.height; ++y) {
      const T* const p = pressure + std::ptrdiff_t{y} * from.width;
      T* const out = part + std::ptrdiff_t{y} * to.width;
      std::fill_n(out, to.width, T(0));
      add_rows(out, to.width, from.width, [&](Index x) {
        return std::pair{p[x], kernel_.across(term, from.left + x) + to.left};
      });
    }
  }

  void down(T* out, const Cells& to, const T* part, const Cells& from, std::size_t term) const {
    for (Index y = 0; y < to.height; ++y) {
      add_rows(out + std::ptrdiff_t{y} * to.width, to.width, from.height, [&](Index j) {
        return std::pair{kernel_.down(term, to.top + y - from.top - j),
                         part + std::ptrdiff_t{j} * to.width};
      });
    }
  }

  // Adds `count` rows, each times a factor; four at a time, of which the last may count for
  // nothing.
  template <class Source>
  static void add_rows(T* out, Index width, Index count, const Source& source) {
    for (Index k = 0; k < count; k += 4) {
      std::array<T, 4> factors{};
      std::array<const T*, 4> rows{};
      bool is_any = false;
      for (std::size_t i = 0; i < 4; ++i) {
        const Index at = std::min(k + static_cast<Index>(i), count - 1);
        const auto [factor, row] = source(at);
        factors[i] = k + static_cast<Index>(i) < count ? factor : T(0);
        rows[i] = row;
        is_any = is_any || factors[i] != 0;
      }
      if (is_any) add_four_rows(out, factors, rows, width);
    }
  }

  Index step_, width_, height_;
  T softness_ = 0;
  SeparableKernel<T> kernel_;
};

/// A rigid object on a coarse layer, in a box of cells: the pressure by which the layer's surface
/// is where the object stands, and not in it elsewhere, nowhere less than nothing. By conjugate
/// gradients on the cells that bear (after Polonsky and Keer, as `solve_bounded`), in memory that
/// is used again.
template <class T>
class CoarseContact {
 public:
  CoarseContact() = default;
  explicit CoarseContact(std::size_t most_cells) {
    for (auto* const values : {&wanted, &pressure, &gap_, &step_, &answer_}) {
      values->resize(most_cells);
    }
  }

  std::vector<T> wanted;    ///< how far each cell is to sink; -infinity: nothing to touch
  std::vector<T> pressure;  ///< the answer

  /// Ends when each gap, or where it is less the pressure times the softness, is below `accuracy`,
  /// or after `most_iterations`. `part` is worked in. Returns whether it is as accurate.
  bool solve(const CoarseLayer<T>& layer, const Cells& box, T accuracy, int most_iterations,
             T* part) {
    const std::size_t count = box.area();
    begin(layer, box, part);
    T last = 0;
    for (int iteration = 0;; ++iteration) {
      T square = 0, left = 0;
      for (std::size_t i = 0; i < count; ++i) {
        if (is_free(i)) square += gap_[i] * gap_[i];
        const T lifts = std::min(gap_[i], layer.softness() * pressure[i]);
        left = std::max(left, std::abs(std::min(lifts, gap_[i])));
      }
      if (left <= accuracy) return true;
      if (iteration == most_iterations || !(square > 0)) return false;
      const T keep = last > 0 ? square / last : 0;
      last = square;
      T along = 0, bending = 0;
      for (std::size_t i = 0; i < count; ++i) {
        step_[i] = is_free(i) ? gap_[i] + keep * step_[i] : 0;
        along += step_[i] * (is_free(i) ? gap_[i] : 0);
      }
      layer.sink(answer_.data(), box, step_.data(), box, part);
      for (std::size_t i = 0; i < count; ++i) bending += step_[i] * answer_[i];
      if (!(bending > 0)) return false;
      move(layer, box, along / bending, part);
    }
  }

 private:
  [[nodiscard]] bool is_free(std::size_t i) const { return pressure[i] > 0 || gap_[i] < 0; }

  // From pressures in proportion to what is wanted.
  void begin(const CoarseLayer<T>& layer, const Cells& box, T* part) {
    const std::size_t count = box.area();
    std::fill_n(step_.begin(), count, T(0));
    for (std::size_t i = 0; i < count; ++i) pressure[i] = std::max(wanted[i], T(0));
    layer.sink(answer_.data(), box, pressure.data(), box, part);
    T along = 0, bending = 0;
    for (std::size_t i = 0; i < count; ++i) {
      along += pressure[i] * pressure[i];
      bending += pressure[i] * answer_[i];
    }
    const T scale = bending > 0 ? along / bending : 0;
    for (std::size_t i = 0; i < count; ++i) {
      pressure[i] *= scale;
      gap_[i] = scale * answer_[i] - wanted[i];
    }
  }

  void move(const CoarseLayer<T>& layer, const Cells& box, T length, T* part) {
    const std::size_t count = box.area();
    bool is_straight = true;
    for (std::size_t i = 0; i < count; ++i) {
      const T next = pressure[i] - length * step_[i];
      is_straight = is_straight && next >= 0;
      pressure[i] = std::max(next, T(0));
    }
    if (!is_straight) layer.sink(gap_.data(), box, pressure.data(), box, part);
    for (std::size_t i = 0; i < count; ++i) {
      gap_[i] -= is_straight ? length * answer_[i] : wanted[i];
    }
  }

  std::vector<T> gap_, step_, answer_;
};

}  // namespace gelight::detail
