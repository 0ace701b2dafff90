#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// A rigid object above springs that a taut membrane couples. The membrane's displacement w solves
/// a screened Poisson equation with contact complementarity,
///     w - reach^2 laplace(w) = p,   p >= 0,   w >= u,   p (w - u) = 0,
/// with u how far the object is past the membrane at rest, p the contact's pressure over the
/// springs' stiffness, and no slope across the image's border. By over-relaxed Gauss-Seidel sweeps
/// over red and black pixels, projected onto w >= u (Cryer, The solution of a quadratic programming
/// problem using systematic overrelaxation, 1971, doi:10.1137/0309028).
template <class T>
class TautMembrane {
 public:
  /// To which share of the load sums are exact.
  static constexpr double accuracy = 1e-10;

  /// The reach, how far tension carries a displacement, in columns and in rows.
  TautMembrane(const LoneSprings<T>& object, Index width, Index height, double reach_x,
               double reach_y, const CancelHook& cancelled)
      : object_(object),
        cancelled_(cancelled),
        width_(width),
        height_(height),
        across_(reach_x * reach_x),
        down_(reach_y * reach_y),
        w_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        touching_(w_.size()) {
    // The best factor for these equations, from the largest eigenvalue of Jacobi's iteration.
    const double jacobi = 2 * (across_ + down_) / (1 + 2 * (across_ + down_));
    relaxation_ = 2 / (1 + std::sqrt(1 - jacobi * jacobi));
  }

  [[nodiscard]] double least_gap() const { return object_.least_gap(); }
  [[nodiscard]] double deepest(const RigidMotion& motion) const { return object_.deepest(motion); }

  /// Presses the object in, starting from where the membrane was, and sums up the pressure on it.
  [[nodiscard]] SpringSums sums(const RigidMotion& motion, bool tilts) {
    settle(motion);
    SpringSums s;
    for_contact(w_, [&](Index x, Index y, double p) {
      s.load += p;
      s.x_load += p * x;
      s.y_load += p * y;
    });
    for_contact(rate([](Index, Index) { return 1.0; }), [&](Index x, Index y, double p) {
      s.count += p;
      s.x += p * x;
      s.y += p * y;
    });
    if (!tilts) return s;
    for_contact(rate([](Index x, Index) { return double{1} * x; }),
                [&](Index x, Index y, double p) {
                  s.xx += p * x;
                  s.xy += p * y;
                });
    for_contact(rate([](Index, Index y) { return double{1} * y; }),
                [&](Index, Index y, double p) { s.yy += p * y; });
    return s;
  }

  /// Writes the displacement and where the object touches.
  void write(Image<T>& displacement, Image<std::uint8_t>& touching) const {
    for (std::size_t i = 0; i < w_.size(); ++i) {
      displacement.pixels()[i] = static_cast<T>(w_.data()[i]);
      touching.pixels()[i] = touching_.data()[i] != 0 ? 1 : 0;
    }
  }

 private:
  [[nodiscard]] std::ptrdiff_t at(Index x, Index y) const { return std::ptrdiff_t{y} * width_ + x; }

  void settle(const RigidMotion& motion) {
    const auto obstacle = [&](Index x, Index y) { return motion.at(x, y) - object_.gap(x, y); };
    relax(w_, 1e-13, [&](Index x, Index y, double free) { return std::max(free, obstacle(x, y)); });
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        touching_[at(x, y)] = w_[at(x, y)] <= obstacle(x, y) ? 1 : 0;
      }
    }
  }

  // How the displacement changes with a motion of what touches.
  template <class Motion>
  [[nodiscard]] Array<double> rate(const Motion& motion) const {
    Array<double> change(w_.size());
    // A direction need not be exact for Newton's method to arrive.
    relax(change, 1e-6, [&](Index x, Index y, double free) {
      return touching_[at(x, y)] != 0 ? motion(x, y) : free;
    });
    return change;
  }

  // The sum of the four neighbours' weighted values, and of their weights.
  struct Pull {
    double value = 0, weight = 0;
  };
  [[nodiscard]] Pull pull(const Array<double>& w, Index x, Index y) const {
    const std::ptrdiff_t i = at(x, y);
    Pull sum;
    const auto add = [&](bool inside, std::ptrdiff_t neighbour, double weight) {
      if (!inside) return;
      sum.value += weight * w[neighbour];
      sum.weight += weight;
    };
    add(x > 0, i - 1, across_);
    add(x + 1 < width_, i + 1, across_);
    add(y > 0, i - width_, down_);
    add(y + 1 < height_, i + width_, down_);
    return sum;
  }

  // Sweeps until no pixel changes by more than a share of the largest value.
  template <class Constrain>
  void relax(Array<double>& w, double tolerance, const Constrain& constrain) const {
    constexpr int most_sweeps = 100000;
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
      double change = 0, largest = 0;
      const auto move = [&](Index x, Index y, double mean) {
        double& value = w[at(x, y)];
        const double next = constrain(x, y, value + relaxation_ * (mean - value));
        change = std::max(change, std::abs(next - value));
        largest = std::max(largest, std::abs(next));
        value = next;
      };
      const auto move_border = [&](Index x, Index y) {
        const Pull sum = pull(w, x, y);
        move(x, y, sum.value / (1 + sum.weight));
      };
      const double across = across_ / (1 + 2 * (across_ + down_));
      const double down = down_ / (1 + 2 * (across_ + down_));
      for (const Index colour : {0, 1}) {
        for (Index y = 0; y < height_; ++y) {
          const bool is_inside = y > 0 && y < height_ - 1;
          Index x = (y + colour) % 2;
          for (; x < (is_inside ? 1 : width_); x += 2) move_border(x, y);
          for (; x < width_ - 1; x += 2) {
            const double* const here = &w[at(x, y)];
            move(x, y, across * (here[-1] + here[1]) + down * (here[-width_] + here[width_]));
          }
          for (; x < width_; x += 2) move_border(x, y);
        }
      }
      if (change <= tolerance * largest) return;
      // How many sweeps there will be is not known: done is half of them after the usual number.
      ++sweeps_;
      cancelled_.check(1 - usual_sweeps / (usual_sweeps + sweeps_), "pressing into taut gel");
    }
  }

  // Calls work(x, y, pressure) for every spring that the object touches.
  template <class Work>
  void for_contact(const Array<double>& w, const Work& work) const {
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        if (touching_[at(x, y)] == 0) continue;
        const Pull sum = pull(w, x, y);
        work(x, y, (1 + sum.weight) * w[at(x, y)] - sum.value);
      }
    }
  }

  static constexpr double usual_sweeps = 1000;

  const LoneSprings<T>& object_;
  const CancelHook& cancelled_;
  mutable double sweeps_ = 0;
  Index width_, height_;
  double across_, down_, relaxation_;
  Array<double> w_;
  Array<char> touching_;
};

}  // namespace gelight::detail
