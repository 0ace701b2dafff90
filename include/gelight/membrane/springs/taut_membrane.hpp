#pragma once

#include <algorithm>
#include <array>
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

  /// How many springs bear at most: what the object presses in takes all others along.
  [[nodiscard]] double most() const { return static_cast<double>(w_.size()); }
  /// What one bears at most by its own displacement and its neighbours', over that.
  [[nodiscard]] double stiffest() const { return 1 + 4 * (across_ + down_); }
  /// Whether the last sums are those of an equilibrium of the membrane.
  [[nodiscard]] bool is_settled() const { return is_settled_; }

  /// Presses the object in, starting from where the membrane was, and sums up the pressure on it.
  [[nodiscard]] SpringSums sums(const RigidMotion& motion, bool tilts) {
    settle(motion);
    SpringSums s;
    for_contact(w_, [&](Index x, Index y, double p) {
      s.load += p;
      s.count += 1;
      if (!tilts) return;
      const double column = x, row = y;
      s.x_load += p * column;
      s.y_load += p * row;
      s.x += column;
      s.y += row;
      s.xx += column * column;
      s.xy += column * row;
      s.yy += row * row;
    });
    return s;
  }

  /// How the load along each of some motions grows with each of them. They are orthonormal, or
  /// none, over the pixels that are touched: those that move nothing there, as tilts about a line
  /// of pixels, would else be lost in what the others are rounded by.
  [[nodiscard]] Eigen::Matrix3d resistance(const std::array<RigidMotion, 3>& motions) const {
    Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
    for (Index k = 0; k < 3; ++k) {
      const RigidMotion& moved = motions[static_cast<std::size_t>(k)];
      if (moved.is_none()) continue;
      Vec3<double> load = Vec3<double>::Zero();
      for_contact(change_by(moved), [&](Index x, Index y, double p) {
        for (Index i = 0; i < 3; ++i) load[i] += p * motions[static_cast<std::size_t>(i)].at(x, y);
      });
      result.col(k) = load;
    }
    return 0.5 * (result + result.transpose());
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
    // Nothing moves further than the object at its deepest: without this a membrane that is left
    // alone would only halve its way to rest, again and again.
    const double deepest = std::max(0.0, object_.deepest(motion));
    for (double& w : w_) w = std::min(w, deepest);
    is_settled_ = relax(
        w_, 1e-13, [&](Index x, Index y, double free) { return std::max(free, obstacle(x, y)); });
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        touching_[at(x, y)] = w_[at(x, y)] <= obstacle(x, y) ? 1 : 0;
      }
    }
  }

  // How the displacement changes with a motion of what touches.
  [[nodiscard]] Array<double> change_by(const RigidMotion& motion) const {
    Array<double> change(w_.size());
    // A direction need not be exact for Newton's method to arrive.
    (void)relax(change, 1e-6, [&](Index x, Index y, double free) {
      return touching_[at(x, y)] != 0 ? motion.at(x, y) : free;
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

  // Sweeps until no pixel changes by more than a share of the largest value; whether that came.
  template <class Constrain>
  [[nodiscard]] bool relax(Array<double>& w, double tolerance, const Constrain& constrain) const {
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
      if (change <= tolerance * largest) return true;
      // How many sweeps there will be is not known: done is half of them after the usual number.
      ++sweeps_;
      cancelled_.check(1 - usual_sweeps / (usual_sweeps + sweeps_), "pressing into taut gel");
    }
    return false;
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
  bool is_settled_ = true;
};

}  // namespace gelight::detail
