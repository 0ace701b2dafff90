#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/membrane/springs/taut_grids.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// The gaps of an object above pixels twice as large: means of those there are.
class HalvedGaps {
 public:
  template <class Object>
  HalvedGaps(const Object& object, Index width, Index height)
      : width_((width + 1) / 2), height_((height + 1) / 2) {
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) gaps_.push_back(mean(object, x, y, width, height));
    }
  }

  [[nodiscard]] Index width() const { return width_; }
  [[nodiscard]] Index height() const { return height_; }
  [[nodiscard]] double gap(Index x, Index y) const { return gaps_[std::ptrdiff_t{y} * width_ + x]; }
  /// How far a motion without tilt takes the object into the gel at most.
  [[nodiscard]] double deepest(const RigidMotion& motion) const {
    return motion.offset - *std::min_element(gaps_.begin(), gaps_.end());
  }

 private:
  template <class Object>
  [[nodiscard]] static double mean(const Object& object, Index column, Index row, Index width,
                                   Index height) {
    double sum = 0;
    int count = 0;
    for (Index y = 2 * row; y < std::min(2 * row + 2, height); ++y) {
      for (Index x = 2 * column; x < std::min(2 * column + 2, width); ++x) {
        const double gap = object.gap(x, y);
        if (!std::isfinite(gap)) continue;
        sum += gap;
        ++count;
      }
    }
    return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
  }

  Index width_, height_;
  Array<double> gaps_;
};

/// A rigid object above springs that a taut membrane couples. The membrane's displacement w solves
/// a screened Poisson equation with contact complementarity,
///     w - reach^2 laplace(w) = p,   p >= 0,   w >= u,   p (w - u) = 0,
/// with u how far the object is past the membrane at rest, p the contact's pressure over the
/// springs' stiffness, and no slope across the image's border. Alternates projected Gauss-Seidel
/// sweeps, which find the contact, with a multigrid cycle for what does not touch, projected too
/// and cut where the energy is least along it: so the energy falls in every step, to its least
/// value. (Graeser and Kornhuber, Multigrid methods for obstacle problems, 2009,
/// doi:10.4208/jcm.2009.27.1.001)
template <class Object>
class TautMembrane {
 public:
  /// To which share of the load sums are exact.
  static constexpr double accuracy = 1e-10;

  /// The reach, how far tension carries a displacement, in columns and in rows. `cycles` are those
  /// that the search has had on coarser grids.
  TautMembrane(const Object& object, Index width, Index height, double reach_x, double reach_y,
               const CancelHook& cancelled, double cycles = 0)
      : object_(object),
        cancelled_(cancelled),
        cycles_(cycles),
        width_(width),
        height_(height),
        across_(reach_x * reach_x),
        down_(reach_y * reach_y),
        w_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        grid_(width, height, across_, down_),
        grids_(width, height, across_, down_),
        none_(w_.size()),
        obstacle_(w_.size()),
        left_(w_.size()),
        step_(w_.size()),
        touching_(w_.size()) {
    for (Array<double>& change : changes_) change.resize(w_.size());
  }

  [[nodiscard]] double deepest(const RigidMotion& motion) const { return object_.deepest(motion); }

  /// Nearly the displacement, without tilt, at which the pressures sum up to `load`, found on
  /// coarser grids from a guess; the membrane is nearly there, too.
  double approach(double load, double guess) {
    constexpr Index smallest = 16;
    wanted_ = load;
    if (std::min(width_, height_) < smallest || across_ + down_ < 1) return guess;
    const HalvedGaps halved(object_, width_, height_);
    TautMembrane<HalvedGaps> coarse(halved, halved.width(), halved.height(), std::sqrt(across_) / 2,
                                    std::sqrt(down_) / 2, cancelled_);
    guess = coarse.press(load / 4, coarse.approach(load / 4, guess));
    cycles_ = coarse.cycles();
    begin_from(coarse.displacement(), halved.width(), halved.height(), guess);
    return guess;
  }

  /// A few of Newton's steps towards a displacement at which the pressures sum up to `load`.
  double press(double load, double guess) {
    constexpr int most_steps = 4;
    constexpr double near = 1e-3;
    for (int step = 0; step < most_steps; ++step) {
      const SpringSums s = sums({guess, 0, 0}, false);
      if (!(s.count > 0) || std::abs(s.load - load) <= near * load) break;
      guess += (load - s.load) / resistance({RigidMotion{1, 0, 0}, {}, {}})(0, 0);
    }
    return guess;
  }

  [[nodiscard]] double cycles() const { return cycles_; }
  /// The membrane's displacement, row after row.
  [[nodiscard]] const Array<double>& displacement() const { return w_; }

  /// How many springs bear at most: what the object presses in takes all others along.
  [[nodiscard]] double most() const { return static_cast<double>(w_.size()); }
  /// What one bears at most by its own displacement and its neighbours', over that.
  [[nodiscard]] double stiffest() const { return 1 + 4 * (across_ + down_); }
  /// The load that is looked for: as long as it is missing, sums may be off by a thousandth of
  /// what is. 0: always exact.
  void expect(double load) { wanted_ = load; }
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
  [[nodiscard]] Eigen::Matrix3d resistance(const std::array<RigidMotion, 3>& motions) {
    Eigen::Matrix3d result{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (Index k = 0; k < 3; ++k) {
      const RigidMotion& moved = motions[static_cast<std::size_t>(k)];
      if (moved.is_none()) continue;
      Vec3<double> load(0, 0, 0);
      const Array<double>& change = change_by(static_cast<std::size_t>(k), moved);
      for_contact(change, [&](Index x, Index y, double p) {
        for (Index i = 0; i < 3; ++i) load[i] += p * motions[static_cast<std::size_t>(i)].at(x, y);
      });
      for (Index i = 0; i < 3; ++i) result(i, k) = load[i];
    }
    for (Index k = 0; k < 3; ++k) {
      for (Index i = 0; i < k; ++i) {
        result(i, k) = result(k, i) = 0.5 * (result(i, k) + result(k, i));
      }
    }
    return result;
  }

  /// Writes the displacement and where the object touches.
  template <class T>
  void write(Image<T>& displacement, Image<std::uint8_t>& touching) const {
    for (std::size_t i = 0; i < w_.size(); ++i) {
      displacement.pixels()[i] = static_cast<T>(w_.data()[i]);
      touching.pixels()[i] = touching_.data()[i] != 0 ? 1 : 0;
    }
  }

 private:
  [[nodiscard]] std::ptrdiff_t at(Index x, Index y) const { return std::ptrdiff_t{y} * width_ + x; }

  void settle(const RigidMotion& motion) {
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        obstacle_[at(x, y)] = motion.at(x, y) - object_.gap(x, y);
      }
    }
    follow(motion);
    const auto press = [&](std::ptrdiff_t i, double free) { return std::max(free, obstacle_[i]); };
    is_settled_ = improve(w_, press, [&](double change) {
      double load = 0;  // the springs' own: tension adds none
      for (std::size_t i = 0; i < w_.size(); ++i) {
        touching_.data()[i] = w_.data()[i] <= obstacle_.data()[i] ? 1 : 0;
        load += w_.data()[i];
      }
      const double missing = wanted_ > 0 ? std::abs(load / wanted_ - 1) : 0;
      return change <= std::clamp(1e-3 * missing, 1e-13, 1e-4);
    });
  }

  // Moves the membrane as it would go if the same pixels touched, which is nearly where it goes;
  // but neither up nor further than the object at its deepest.
  void follow(const RigidMotion& motion) {
    const bool is_known =
        is_straight_ && motion.per_column == last_.per_column && motion.per_row == last_.per_row;
    const double by = is_known ? (motion.offset - last_.offset) / moved_ : 0;
    const double deepest = std::max(0.0, object_.deepest(motion));
    for (std::size_t i = 0; i < w_.size(); ++i) {
      const double value = std::clamp(w_.data()[i] + by * changes_[0].data()[i], 0.0, deepest);
      w_.data()[i] = std::max(value, obstacle_.data()[i]);
    }
    last_ = motion;
  }

  // How the displacement changes with a motion of what touches.
  [[nodiscard]] const Array<double>& change_by(std::size_t which, const RigidMotion& motion) {
    Array<double>& change = changes_[which];
    for (Index y = 0; y < height_; ++y) {
      for (Index x = 0; x < width_; ++x) {
        if (touching_[at(x, y)] != 0) change[at(x, y)] = motion.at(x, y);
      }
    }
    if (which == 0) {
      is_straight_ = motion.per_column == 0 && motion.per_row == 0;
      moved_ = motion.offset;
    }
    const auto hold = [&](std::ptrdiff_t i, double free) {
      return touching_[i] != 0 ? change[i] : free;
    };
    // A direction need not be exact for Newton's method to arrive.
    (void)improve(change, hold, [](double left) { return left <= 1e-3; });
    return change;
  }

  // Sweeps and cycles until `is_done` with the largest change of a pixel by the last sweeps, as a
  // share of the largest value; whether that came.
  template <class Constrain, class Done>
  [[nodiscard]] bool improve(Array<double>& w, const Constrain& constrain, const Done& is_done) {
    constexpr int most_cycles = 2000;
    for (int cycle = 0; cycle < most_cycles; ++cycle) {
      const double change = grid_.sweep(w, none_, constrain);
      double largest = 0;
      for (const double value : w) largest = std::max(largest, std::abs(value));
      if (is_done(largest > 0 ? change / largest : 0)) return true;
      correct(w, constrain);
      // How many cycles there will be is not known: done is half of them after the usual number.
      ++cycles_;
      cancelled_.check(1 - usual_cycles / (usual_cycles + cycles_), "pressing into taut gel");
    }
    return false;
  }

  // Between a coarser membrane's pixels bilinearly, at its displacement of the object.
  void begin_from(const Array<double>& coarse, Index width, Index height, double displacement) {
    for (Index y = 0; y < height_; ++y) {
      const Index near = y / 2,
                  far = std::clamp(y % 2 == 0 ? near - 1 : near + 1, Index{0}, height - 1);
      for (Index x = 0; x < width_; ++x) {
        const Index c = x / 2, d = std::clamp(x % 2 == 0 ? c - 1 : c + 1, Index{0}, width - 1);
        const auto value = [&](Index column, Index row) {
          return coarse[std::ptrdiff_t{row} * width + column];
        };
        w_[at(x, y)] =
            0.0625 * (9 * value(c, near) + 3 * (value(d, near) + value(c, far)) + value(d, far));
      }
    }
    last_ = {displacement, 0, 0};
  }

  template <class Constrain>
  void correct(Array<double>& w, const Constrain& constrain) {
    grid_.residual(left_, w, none_);
    double scale = 0;  // so that floats hold the lightest
    for (std::size_t i = 0; i < w.size(); ++i) {
      if (touching_.data()[i] != 0) left_.data()[i] = 0;
      scale = std::max(scale, std::abs(left_.data()[i]));
    }
    if (scale < std::numeric_limits<double>::min()) return;
    const Array<float>& correction = grids_.correction(left_, 1 / scale, touching_);
    double along = 0, bending = 0;
    for (std::ptrdiff_t i = 0; i < std::ssize(w); ++i) {
      step_[i] = constrain(i, w[i] + scale * double{correction[i]}) - w[i];
      along += step_[i] * left_[i];
    }
    grid_.residual(left_, step_, none_);
    for (std::ptrdiff_t i = 0; i < std::ssize(w); ++i) bending -= step_[i] * left_[i];
    // As far as the energy falls; beyond the whole of it there may be the object.
    const double share = bending > 0 ? std::clamp(along / bending, 0.0, 1.0) : 0;
    for (std::ptrdiff_t i = 0; i < std::ssize(w); ++i) w[i] += share * step_[i];
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

  static constexpr double usual_cycles = 50;

  const Object& object_;
  const CancelHook& cancelled_;
  double cycles_, wanted_ = 0;
  Index width_, height_;
  double across_, down_;
  Array<double> w_;
  TautGrid<double> grid_;
  TautGrids<float> grids_;
  Array<double> none_;  // no load but the contact's
  Array<double> obstacle_, left_, step_;
  std::array<Array<double>, 3> changes_;  // of w by what was last asked for
  bool is_straight_ = false;              // whether the first of them is by no tilt, but
  double moved_ = 1;                      // by so much
  RigidMotion last_;                      // at which w is
  bool is_settled_ = true;
  Array<char> touching_;
};

}  // namespace gelight::detail
