#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/calibration/linear_fit.hpp"
#include "gelight/shading/fitted.hpp"

namespace gelight::detail {

/// Near lights by nonlinear least squares, on samples of touched gel.
///
/// Colours enter linearly and are solved for at every step, a least-squares problem of their own;
/// places, softness, fall-off and shininess go by a Gauss-Newton step of all numbers at once,
/// damped as Levenberg and Marquardt have it. (Golub, Pereyra, The differentiation of
/// pseudo-inverses and nonlinear least squares problems whose variables separate, 1973,
/// doi:10.1137/0710036)
class LightsFit {
 public:
  /// Lights all around, to start from.
  [[nodiscard]] static LightsReflectance lights_around(int count, double height) {
    LightsReflectance model;
    model.height = height;
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.25) / count;
      model.lights.push_back({{1.6 * std::cos(angle), 1.6 * std::sin(angle), 0.8}, {}, {}});
    }
    return model;
  }

  LightsFit(std::span<const FitSample> samples, LightsReflectance start)
      : samples_(samples), model_(std::move(start)) {
    for (const FitSample& s : samples_) weight_ += s.weight;
  }

  /// Until a step takes less than a share `enough` off the squares.
  [[nodiscard]] LightsReflectance solve(double enough, const CancelHook& cancelled) {
    double least = solve_colours();
    double damping = 1e-2;
    constexpr int most_steps = 40;
    for (int step = 0; step < most_steps && damping < 1e6; ++step) {
      cancelled.check(step / double{most_steps}, "fitting lights");
      const LightsReflectance before = model_;
      const Step linear = linearised();
      bool is_better = false;
      while (!is_better && damping < 1e6) {
        Eigen::MatrixXd damped = linear.matrix;
        damped.diagonal() += damping * linear.matrix.diagonal();
        damped.diagonal().array() += 1e-9 * weight_;
        move(before, solve_in_place(damped, linear.right));
        const double left = solve_colours();
        is_better = left < least;
        damping *= is_better ? 0.2 : 5;
        if (!is_better) {
          model_ = before;
          continue;
        }
        const bool is_done = left > least * (1 - enough);
        least = left;
        if (is_done) return model_;
      }
    }
    return model_;
  }

 private:
  [[nodiscard]] int count() const { return static_cast<int>(model_.lights.size()); }
  // Per channel: a diffuse and a specular share of each light, ambient, contact.
  [[nodiscard]] int linear() const { return 2 * count() + 2; }
  [[nodiscard]] int nonlinear() const { return 3 * count() + 3; }

  void move(const LightsReflectance& from, const Eigen::MatrixXd& step) {
    model_ = from;
    for (int k = 0; k < count(); ++k) {
      Vec3<double>& place = model_.lights[static_cast<std::size_t>(k)].place;
      Vec3<double> by(step(3 * k), step(3 * k + 1), step(3 * k + 2));
      if (norm(by) > 0.5) by *= 0.5 / norm(by);
      place += by;
      place.x() = std::clamp(place.x(), -6.0, 6.0);
      place.y() = std::clamp(place.y(), -6.0, 6.0);
      place.z() = std::clamp(place.z(), 0.1, 6.0);
    }
    const auto scaled = [&](double value, int i, double least, double most) {
      return std::clamp(value * std::exp(std::clamp(step(3 * count() + i), -0.7, 0.7)), least,
                        most);
    };
    model_.softness = scaled(from.softness, 0, 0.01, 3);
    model_.falloff = scaled(from.falloff, 1, 0.05, 4);
    model_.shininess = scaled(from.shininess, 2, 1, 100);
  }

  [[nodiscard]] static Vec3<double> normal_of(const GelPoint& p) {
    return {p.nx, p.ny, std::sqrt(std::max(0.0, 1 - p.nx * p.nx - p.ny * p.ny))};
  }

  // What each colour is multiplied by in a sample, times the root of its weight.
  template <class Row>
  void fill_features(Row&& row, const FitSample& s, double root) const {
    const Vec3<double> n = normal_of(s.point);
    for (int k = 0; k < count(); ++k) {
      const auto terms = light_terms(model_, model_.lights[static_cast<std::size_t>(k)].place, n,
                                     s.point.x, s.point.y);
      row(2 * k) = root * terms.diffuse;
      row(2 * k + 1) = root * terms.specular;
    }
    row(linear() - 2) = root * (1 - n.z());
    row(linear() - 1) = root;
  }

  // The best colours for the places; returns the squares they leave.
  double solve_colours() {
    const int l = linear();
    Eigen::MatrixXd rows(samples_.size(), l + 3);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      auto row = rows.row(static_cast<Eigen::Index>(i));
      const double root = std::sqrt(samples_[i].weight);
      fill_features(row, samples_[i], root);
      for (std::size_t c = 0; c < 3; ++c) {
        row(l + static_cast<Eigen::Index>(c)) = root * samples_[i].change[c];
      }
    }
    const Eigen::MatrixXd squares = rows.transpose() * rows;
    Eigen::MatrixXd matrix = squares.topLeftCorner(l, l);
    matrix.diagonal().array() += ridge * weight_;
    const Eigen::MatrixXd right = squares.topRightCorner(l, 3);
    const Eigen::MatrixXd best = solve_in_place(matrix, right);
    double left = 0;
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      for (int k = 0; k < count(); ++k) {
        NearLight& light = model_.lights[static_cast<std::size_t>(k)];
        light.diffuse[channel] = best(2 * k, c);
        light.specular[channel] = best(2 * k + 1, c);
      }
      model_.ambient[channel] = best(l - 2, c);
      model_.contact[channel] = best(l - 1, c);
      // At the minimum the penalty and what is left add up to this.
      left += squares(l + c, l + c);
      for (int k = 0; k < l; ++k) left -= right(k, c) * best(k, c);
    }
    return left;
  }

  struct Step {
    Eigen::MatrixXd matrix, right;
  };

  // The normal equations of the numbers that are not colours. Colours follow: only what they cannot
  // make up for counts.
  [[nodiscard]] Step linearised() const {
    const int q = nonlinear(), l = linear();
    const auto size = static_cast<Eigen::Index>(samples_.size());
    std::array<Eigen::MatrixXd, 3> rows;
    for (Eigen::MatrixXd& one : rows) one.setZero(size, q + 1 + l);
    for (Eigen::Index i = 0; i < size; ++i) {
      const FitSample& s = samples_[static_cast<std::size_t>(i)];
      const double root = std::sqrt(s.weight);
      const Change now = change(model_, s.point);
      fill_features(rows[0].row(i).tail(l), s, root);
      for (std::size_t c = 0; c < 3; ++c) {
        rows[c](i, q) = root * (s.change[c] - now[c]);
        if (c > 0) rows[c].row(i).tail(l) = rows[0].row(i).tail(l);
      }
      fill_slopes(rows, i, s, root);
    }
    Step step{Eigen::MatrixXd::Zero(q, q), Eigen::MatrixXd::Zero(q, 1)};
    for (const Eigen::MatrixXd& one : rows) {
      const Eigen::MatrixXd squares = one.transpose() * one;
      Eigen::MatrixXd colours = squares.bottomRightCorner(l, l);
      colours.diagonal().array() += ridge * weight_;
      const Eigen::MatrixXd mixed = squares.bottomLeftCorner(l, q);
      const Eigen::MatrixXd followed = solve_in_place(colours, mixed);
      const Eigen::MatrixXd taken = mixed.transpose() * followed;
      step.matrix += squares.topLeftCorner(q, q) - taken;
      step.right += squares.col(q).head(q);
    }
    return step;
  }

  // How a light's two terms change with its place and with the logarithms of softness, fall-off
  // and shininess.
  struct Slopes {
    std::array<double, 6> diffuse, specular;
  };
  [[nodiscard]] Slopes slopes_of(const Vec3<double>& place, const Vec3<double>& n,
                                 const GelPoint& p) const {
    const Vec3<double> way(place.x() - p.x, place.y() - p.y * model_.height, place.z());
    const double distance = norm(way), share = std::pow(distance, -model_.falloff);
    const Vec3<double> l = way / distance;
    const double cosine = dot(n, l), level = l.z();
    const Vec3<double> by_cosine = (n - cosine * l) / distance;
    const Vec3<double> by_level = (Vec3<double>(0, 0, 1) - level * l) / distance;
    const Vec3<double> by_distance = -model_.falloff / distance * l;
    const Soft lit = soft(cosine), rest = soft(level);
    const double highlight = 2 * std::max(0.0, cosine) * n.z() - level;
    const Shine shone = shine(highlight), shone_at_rest = shine(level);
    const double diffuse = lit.value - rest.value, specular = shone.value - shone_at_rest.value;
    Slopes slopes;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double by_highlight = (cosine > 0 ? 2 * n.z() * by_cosine[axis] : 0.0) - by_level[axis];
      slopes.diffuse[a] = share * (diffuse * by_distance[axis] + lit.slope * by_cosine[axis] -
                                   rest.slope * by_level[axis]);
      slopes.specular[a] = share * (specular * by_distance[axis] + shone.slope * by_highlight -
                                    shone_at_rest.slope * by_level[axis]);
    }
    const double by_falloff = -share * std::log(distance) * model_.falloff;
    slopes.diffuse[3] = share * (lit.by_softness - rest.by_softness);
    slopes.specular[3] = 0;
    slopes.diffuse[4] = by_falloff * diffuse;
    slopes.specular[4] = by_falloff * specular;
    slopes.diffuse[5] = 0;
    slopes.specular[5] = share * (shone.by_shininess - shone_at_rest.by_shininess);
    return slopes;
  }

  struct Soft {
    double value, slope, by_softness;
  };
  [[nodiscard]] Soft soft(double x) const {
    const double t = x / model_.softness, value = soft_positive(x, model_.softness);
    const double slope = 1 / (1 + std::exp(-t));
    return {value, slope, value - x * slope};
  }
  struct Shine {
    double value, slope, by_shininess;
  };
  [[nodiscard]] Shine shine(double base) const {
    if (base <= 0) return {0, 0, 0};
    const double value = std::pow(base, model_.shininess);
    return {value, model_.shininess * value / base, model_.shininess * std::log(base) * value};
  }

  void fill_slopes(std::array<Eigen::MatrixXd, 3>& rows, Eigen::Index i, const FitSample& s,
                   double root) const {
    const Vec3<double> n = normal_of(s.point);
    for (int k = 0; k < count(); ++k) {
      const NearLight& light = model_.lights[static_cast<std::size_t>(k)];
      const Slopes by = slopes_of(light.place, n, s.point);
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t a = 0; a < 6; ++a) {
          const double value =
              light.diffuse[c] * by.diffuse[a] + light.specular[c] * by.specular[a];
          const int own = 3 * k + static_cast<int>(a);
          const int shared = 3 * count() + static_cast<int>(a) - 3;
          rows[c](i, a < 3 ? own : shared) += root * value;
        }
      }
    }
  }

  static constexpr double ridge = 1e-4;

  std::span<const FitSample> samples_;
  LightsReflectance model_;
  double weight_ = 0;
};

}  // namespace gelight::detail
