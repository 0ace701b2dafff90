#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
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
/// damped as Levenberg and Marquardt have it.
class LightsFit {
 public:
  LightsFit(std::span<const FitSample> samples, double height) : samples_(samples) {
    model_.height = height;
  }

  [[nodiscard]] LightsReflectance solve(int lights, const CancelHook& cancelled) {
    start(lights);
    double least = solve_colours();
    double damping = 1e-2;
    constexpr int most_steps = 40;
    for (int step = 0; step < most_steps && damping < 1e6; ++step) {
      cancelled.check(step / double{most_steps}, "fitting lights");
      const LightsReflectance before = model_;
      const auto [matrix, right] = linearised();
      bool is_better = false;
      while (!is_better && damping < 1e6) {
        Eigen::MatrixXd damped = matrix;
        damped.diagonal() +=
            damping * matrix.diagonal() + Eigen::VectorXd::Constant(matrix.rows(), 1e-9 * weight_);
        move(before, Eigen::LLT<Eigen::MatrixXd>(damped).solve(right));
        const double left = solve_colours();
        is_better = left < least;
        damping *= is_better ? 0.2 : 5;
        if (!is_better) {
          model_ = before;
          continue;
        }
        const bool is_done = left > least * (1 - 1e-4);
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

  void start(int lights) {
    for (int k = 0; k < lights; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.25) / lights;
      model_.lights.push_back({{1.6 * std::cos(angle), 1.6 * std::sin(angle), 0.8}, {}, {}});
    }
  }

  void move(const LightsReflectance& from, const Eigen::VectorXd& step) {
    model_ = from;
    for (int k = 0; k < count(); ++k) {
      Vec3<double>& place = model_.lights[static_cast<std::size_t>(k)].place;
      Vec3<double> by = step.segment<3>(3 * k);
      if (by.norm() > 0.5) by *= 0.5 / by.norm();
      place += by;
      place.x() = std::clamp(place.x(), -6.0, 6.0);
      place.y() = std::clamp(place.y(), -6.0, 6.0);
      place.z() = std::clamp(place.z(), 0.1, 6.0);
    }
    const auto scaled = [&](double value, int i, double least, double most) {
      return std::clamp(value * std::exp(std::clamp(step[3 * count() + i], -0.7, 0.7)), least,
                        most);
    };
    model_.softness = scaled(from.softness, 0, 0.01, 3);
    model_.falloff = scaled(from.falloff, 1, 0.05, 4);
    model_.shininess = scaled(from.shininess, 2, 1, 100);
  }

  [[nodiscard]] Eigen::VectorXd features(const LightsReflectance& model, const FitSample& s) const {
    Eigen::VectorXd row(linear());
    const GelPoint& p = s.point;
    const double nz = std::sqrt(std::max(0.0, 1 - p.nx * p.nx - p.ny * p.ny));
    for (int k = 0; k < count(); ++k) {
      const auto terms = light_terms(model, model.lights[static_cast<std::size_t>(k)].place,
                                     {p.nx, p.ny, nz}, p.x, p.y);
      row[2 * k] = terms.diffuse;
      row[2 * k + 1] = terms.specular;
    }
    row[linear() - 2] = 1 - nz;
    row[linear() - 1] = 1;
    return row;
  }

  [[nodiscard]] Eigen::MatrixX3d colours() const {
    Eigen::MatrixX3d all(linear(), 3);
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      for (int k = 0; k < count(); ++k) {
        const NearLight& light = model_.lights[static_cast<std::size_t>(k)];
        all(2 * k, c) = light.diffuse[channel];
        all(2 * k + 1, c) = light.specular[channel];
      }
      all(linear() - 2, c) = model_.ambient[channel];
      all(linear() - 1, c) = model_.contact[channel];
    }
    return all;
  }

  // The best colours for the places; returns the squares they leave.
  double solve_colours() {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(linear(), linear());
    Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(linear(), 3);
    double squares = 0;
    weight_ = 0;
    for (const FitSample& s : samples_) {
      const Eigen::VectorXd row = features(model_, s);
      const Eigen::RowVector3d change(s.change[0], s.change[1], s.change[2]);
      matrix.selfadjointView<Eigen::Lower>().rankUpdate(row, s.weight);
      right += s.weight * row * change;
      squares += s.weight * change.squaredNorm();
      weight_ += s.weight;
    }
    constexpr double ridge = 1e-4;
    Eigen::MatrixXd full = matrix.selfadjointView<Eigen::Lower>();
    Eigen::MatrixXd kept = full;
    kept.diagonal().array() += ridge * weight_;
    const Eigen::MatrixX3d best = kept.llt().solve(right);
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      for (int k = 0; k < count(); ++k) {
        NearLight& light = model_.lights[static_cast<std::size_t>(k)];
        light.diffuse[channel] = best(2 * k, c);
        light.specular[channel] = best(2 * k + 1, c);
      }
      model_.ambient[channel] = best(linear() - 2, c);
      model_.contact[channel] = best(linear() - 1, c);
    }
    return squares - 2 * right.cwiseProduct(best).sum() + best.cwiseProduct(full * best).sum() +
           ridge * weight_ * best.squaredNorm();
  }

  struct Step {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd right;
  };

  // The normal equations of all numbers, with the colours eliminated.
  [[nodiscard]] Step linearised() const {
    const int q = nonlinear(), l = linear();
    const Eigen::MatrixX3d colour = colours();
    Eigen::MatrixXd nn = Eigen::MatrixXd::Zero(q, q), nl = Eigen::MatrixXd::Zero(q, 3 * l),
                    ll = Eigen::MatrixXd::Zero(l, l);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(q);
    Eigen::MatrixX3d right_colours = Eigen::MatrixX3d::Zero(l, 3);
    Eigen::MatrixX3d slope(q, 3);
    for (const FitSample& s : samples_) {
      const Eigen::VectorXd row = features(model_, s);
      slopes(slope, s, colour);
      const Eigen::RowVector3d left =
          Eigen::RowVector3d(s.change[0], s.change[1], s.change[2]) - row.transpose() * colour;
      nn.noalias() += s.weight * slope * slope.transpose();
      right.noalias() += s.weight * slope * left.transpose();
      for (int c = 0; c < 3; ++c) {
        nl.middleCols(c * l, l).noalias() += s.weight * slope.col(c) * row.transpose();
      }
      ll.noalias() += s.weight * row * row.transpose();
      right_colours.noalias() += s.weight * row * left;
    }
    ll.diagonal().array() += 1e-4 * weight_;
    const Eigen::LLT<Eigen::MatrixXd> factor(ll);
    for (int c = 0; c < 3; ++c) {
      const Eigen::MatrixXd block = nl.middleCols(c * l, l);
      nn.noalias() -= block * factor.solve(block.transpose());
      right.noalias() -= block * factor.solve(right_colours.col(c));
    }
    return {nn, right};
  }

  // How the three channels change with each number, by differences.
  void slopes(Eigen::MatrixX3d& slope, const FitSample& s, const Eigen::MatrixX3d& colour) const {
    constexpr double step = 1e-5;
    const GelPoint& p = s.point;
    const Vec3<double> n(p.nx, p.ny, std::sqrt(std::max(0.0, 1 - p.nx * p.nx - p.ny * p.ny)));
    const auto terms = [&](const LightsReflectance& model, const Vec3<double>& place) {
      return light_terms(model, place, n, p.x, p.y);
    };
    LightsReflectance softer, steeper, shinier;
    softer.height = steeper.height = shinier.height = model_.height;
    for (LightsReflectance* other : {&softer, &steeper, &shinier}) {
      other->softness = model_.softness;
      other->falloff = model_.falloff;
      other->shininess = model_.shininess;
    }
    softer.softness *= 1 + step;
    steeper.falloff *= 1 + step;
    shinier.shininess *= 1 + step;
    slope.bottomRows(3).setZero();
    for (int k = 0; k < count(); ++k) {
      const Vec3<double>& place = model_.lights[static_cast<std::size_t>(k)].place;
      const LightTerms here = terms(model_, place);
      const auto change = [&](const LightTerms& there) -> Eigen::RowVector3d {
        return (there.diffuse - here.diffuse) / step * colour.row(2 * k) +
               (there.specular - here.specular) / step * colour.row(2 * k + 1);
      };
      for (int axis = 0; axis < 3; ++axis) {
        Vec3<double> moved = place;
        moved[axis] += step;
        slope.row(3 * k + axis) = change(terms(model_, moved));
      }
      const int shared = 3 * count();
      slope.row(shared) += change(terms(softer, place));
      slope.row(shared + 1) += change(terms(steeper, place));
      slope.row(shared + 2) += change(terms(shinier, place));
    }
  }

  std::span<const FitSample> samples_;
  LightsReflectance model_;
  double weight_ = 0;
};

}  // namespace gelight::detail
