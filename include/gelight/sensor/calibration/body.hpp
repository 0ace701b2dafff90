#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/calibrated.hpp"
#include "gelight/sensor/calibration/ball_surface.hpp"
#include "gelight/sensor/calibration/circle.hpp"
#include "gelight/sensor/calibration/circles.hpp"
#include "gelight/sensor/calibration/lights_fit.hpp"
#include "gelight/sensor/calibration/linear_fit.hpp"
#include "gelight/shading/fitted.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

[[nodiscard]] inline double background_level(const Image<Rgb8>& background, Index x, Index y,
                                             std::size_t c) {
  return std::max(1.0, double{1} * background(x, y)[c]);
}

/// The distance of the pixel that is farthest from a circle's centre within the image.
[[nodiscard]] inline double farthest_corner(const Circle& circle, const Image<Rgb8>& image) {
  return std::hypot(std::max(circle.x, image.width() - 1 - circle.x),
                    std::max(circle.y, image.height() - 1 - circle.y));
}

/// Throws InvalidInput for an image that is constant, or saturated for a fifth.
inline void require_photograph(const Image<Rgb8>& image, const std::string& name) {
  for (std::size_t c = 0; c < 3; ++c) {
    int least = 255, most = 0;
    std::size_t saturated = 0;
    for (const Rgb8& pixel : image.pixels()) {
      least = std::min<int>(least, pixel[c]);
      most = std::max<int>(most, pixel[c]);
      if (pixel[c] == 255) ++saturated;
    }
    require(least < most, name, " is constant: channel ", c, " is ", least, " everywhere");
    require(saturated * 5 < image.pixels().size(), name, " is saturated: channel ", c,
            " is 255 at ", saturated, " of ", image.pixels().size(), " pixels");
  }
}

/// From this share of the way to the farthest corner on, pixels are far from any contact.
inline constexpr double far_share = 0.8;

// Fewer pixels show no slope.
inline constexpr double least_circle = 3;

/// Throws InvalidInput, naming press and field, for a circle that is marked where none can be.
inline void require_circle(const BallPress& press) {
  const Circle& c = press.contact;
  const Image<Rgb8>& photo = press.photograph;
  const std::array<std::pair<const char*, double>, 3> fields{
      {{"contact.x", c.x}, {"contact.y", c.y}, {"contact.radius", c.radius}}};
  for (const auto& [field, value] : fields) {
    require(std::isfinite(value), press.name, " has ", field, " ", value, ", which is not finite");
  }
  if (has_no_circle(press)) return;
  require(c.radius > 0, press.name, " has contact.radius ", c.radius,
          ", which is not positive (a circle of which all three numbers are 0 is searched for)");
  require(c.x >= 0 && c.y >= 0 && c.x <= photo.width() - 1 && c.y <= photo.height() - 1, press.name,
          " has its circle at (", c.x, ", ", c.y, "), outside of the image");
  require(c.radius < press.ball_radius, press.name, " has a ball of radius ", press.ball_radius,
          ", smaller than its circle of ", c.radius);
  require(c.radius >= least_circle, press.name, " has a circle of radius ", c.radius,
          ": at least 3 pixels are needed");
  require(c.radius < far_share * farthest_corner(c, photo), press.name, " has a circle of radius ",
          c.radius, ", beside which no gel far from it is seen");
}

GELIGHT_INLINE void require_press(const BallPress& press, const Image<Rgb8>& background) {
  const Image<Rgb8>& photo = press.photograph;
  require(photo.width() == background.width() && photo.height() == background.height(), press.name,
          " has ", photo.width(), " x ", photo.height(), " pixels, the background has ",
          background.width(), " x ", background.height());
  require(press.ball_radius > 0 && std::isfinite(press.ball_radius), press.name,
          " has ball radius ", press.ball_radius, ", which is not positive and finite");
  require_circle(press);
  require_photograph(photo, press.name);
}

/// Everything that a fit works on.
class Calibrator {
 public:
  Calibrator(const Image<Rgb8>& background, std::span<const BallPress> presses,
             const CalibrationOptions& options)
      : background_(background), presses_(presses), options_(options) {
    require_valid();
    for (const BallPress& press : presses_) {
      Entry entry;
      entry.report.name = press.name;
      entry.report.contact = press.contact;
      entry.marked = press.contact;
      if (has_no_circle(press)) propose(press, entry);
      reach_ = std::max(reach_, entry.report.contact.radius / press.ball_radius);
      entries_.push_back(std::move(entry));
    }
    reach_ = std::min(0.999, 1.02 * reach_);
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      entries_[i].report.level = far_level(i);
      require_shown(i);
    }
  }

  [[nodiscard]] Calibration solve() {
    result_.sensor.background = background_;
    const bool are_few = entries_.size() < few_presses;  // to tell which does not fit the others
    const int rounds = are_few ? 0 : options_.refine_circles ? 2 : 1;
    for (int round = 0; round <= rounds; ++round) {
      const CancelHook part =
          options_.cancelled.part(half * round / (rounds + 1), half * (round + 1) / (rounds + 1));
      if (round > 0 && options_.refine_circles) refine_all(part.part(0, half));
      if (round > 0) leave_out();
      fit_touched(round == rounds, part.part(half, 1));
    }
    fit_free();
    report();
    return std::move(result_);
  }

 private:
  struct Entry {
    PressReport report;
    Circle marked;
  };

  void require_valid() const {
    require(!presses_.empty(), "no presses to calibrate from");
    require(options_.model <= ReflectanceModel::table, "reflectance model ", int(options_.model),
            " of 3");
    require(options_.lights >= 3 && options_.lights <= 8, options_.lights,
            " lights: from 3 to 8 can be fitted");
    require(options_.polynomial_degree >= 1 && options_.polynomial_degree <= 8,
            "polynomial degree ", options_.polynomial_degree, " is not from 1 to 8");
    require(
        options_.table_nodes >= 3 && options_.table_nodes % 2 == 1 && options_.table_nodes <= 25,
        "a table of ", options_.table_nodes, " nodes: an odd number from 3 to 25 is wanted");
    require_bulge(options_.bulge_length);
    require(background_.width() > 1 && background_.height() > 1, "a background of ",
            background_.width(), " x ", background_.height(), " pixels");
    require_photograph(background_, "the background");
    for (const BallPress& press : presses_) require_press(press, background_);
  }

  // Inside of its circle a press differs from the background by more than noise does beyond.
  void require_shown(std::size_t i) const {
    const Circle& circle = entries_[i].report.contact;
    const double inside = mean_change(i, -1, circle.radius);
    const double beyond = mean_change(i, far_from(circle), farthest_corner(circle));
    require(inside > 1.1 * beyond, presses_[i].name,
            " shows no press: it differs from the "
            "background by ",
            two_decimals(inside), " grey levels inside of its circle at (", two_decimals(circle.x),
            ", ", two_decimals(circle.y), ") of radius ", two_decimals(circle.radius), ", by ",
            two_decimals(beyond), " far from it");
  }

  // Mean absolute, in a ring, less the photograph's level.
  [[nodiscard]] double mean_change(std::size_t i, double from, double to) const {
    double sum = 0, count = 0;
    for_pixels(entries_[i].report.contact, from, to, [&](Index x, Index y) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum += std::abs(presses_[i].photograph(x, y)[c] - background_(x, y)[c] -
                        entries_[i].report.level[c]);
      }
      count += 3;
    });
    return sum / std::max(1.0, count);
  }

  void propose(const BallPress& press, Entry& entry) {
    require(0.25 * press.ball_radius < std::hypot(background_.width(), background_.height()),
            press.name, " has no circle, and none is searched for of a ball of radius ",
            press.ball_radius, ", which is large beside the image");
    const CircleProposal found =
        propose_circle(background_, press.photograph, press.ball_radius, options_.cancelled);
    require(found.circle.radius >= least_circle, press.name,
            " has no circle; one was searched for, and has radius ",
            two_decimals(found.circle.radius), ": at least 3 pixels are needed");
    entry.report.contact = entry.marked = found.circle;
    entry.report.is_proposed = true;
    result_.warnings.push_back(joined(
        press.name, " has no circle; one was searched for: (", two_decimals(found.circle.x), ", ",
        two_decimals(found.circle.y), ") of radius ", two_decimals(found.circle.radius),
        found.is_sharp ? "" : ", but no rim is sharp: look at it"));
  }
  [[nodiscard]] static std::string two_decimals(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.2f", value);
    return digits;
  }

  // --- pixels ------------------------------------------------------------------------------------

  template <class Work>
  void for_pixels(const Circle& circle, double from, double to, const Work& work) const {
    const auto low = [&](double centre) {
      return static_cast<Index>(std::max(0.0, std::ceil(centre - to)));
    };
    const auto high = [&](double centre, Index size) {
      return static_cast<Index>(std::min(size - 1.0, std::floor(centre + to)));
    };
    const Index last_x = high(circle.x, background_.width());
    const Index last_y = high(circle.y, background_.height());
    for (Index y = low(circle.y); y <= last_y; ++y) {
      const double dy = y - circle.y;
      for (Index x = low(circle.x); x <= last_x; ++x) {
        const double square = (x - circle.x) * (x - circle.x) + dy * dy;
        if (square > from * std::abs(from) && square <= to * to) work(x, y);
      }
    }
  }

  [[nodiscard]] double farthest_corner(const Circle& circle) const {
    return detail::farthest_corner(circle, background_);
  }

  // Beyond 2.5 contact radii, or where the farthest pixels are.
  [[nodiscard]] double far_from(const Circle& circle) const {
    return std::min(2.5 * circle.radius, far_share * farthest_corner(circle));
  }

  // The mean over pixels far from the contact.
  [[nodiscard]] Change far_level(std::size_t i) const {
    const Circle& circle = entries_[i].report.contact;
    Change sum{};
    double count = 0;
    for_pixels(circle, far_from(circle), farthest_corner(circle), [&](Index x, Index y) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += presses_[i].photograph(x, y)[c] - background_(x, y)[c];
      }
      ++count;
    });
    for (double& value : sum) value /= std::max(1.0, count);
    return sum;
  }

  [[nodiscard]] GelPoint place(Index x, Index y) const {
    GelPoint p;
    p.x = 2.0 * x / (background_.width() - 1) - 1;
    p.y = 2.0 * y / (background_.height() - 1) - 1;
    return p;
  }

  [[nodiscard]] FitSample sample(std::size_t i, Index x, Index y, const Vec2<double>& n,
                                 bool touched, double weight) const {
    FitSample s;
    s.point = place(x, y);
    s.point.nx = n.x();
    s.point.ny = n.y();
    s.point.touched = touched;
    double grey = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double b = background_level(background_, x, y, c);
      s.change[c] =
          (presses_[i].photograph(x, y)[c] - background_(x, y)[c] - entries_[i].report.level[c]) /
          b;
      grey += b / (3 * unit_background);
    }
    s.weight = weight * grey * grey;
    s.press = static_cast<int>(i);
    return s;
  }

  [[nodiscard]] std::vector<FitSample> touched_samples() const {
    double pixels = 0;
    for (const Entry& e : entries_)
      pixels += e.report.contact.radius * e.report.contact.radius * 3.14;
    const auto step = static_cast<std::uint32_t>(std::max(1.0, std::floor(pixels / most_samples)));
    std::vector<FitSample> samples;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (!entries_[i].report.fits) continue;
      const Circle& circle = entries_[i].report.contact;
      const double ball = presses_[i].ball_radius;
      for_pixels(circle, -1, std::min(circle.radius, 0.999 * ball), [&](Index x, Index y) {
        if (scattered(x, y) % step != 0) return;
        const Vec2<double> n((x - circle.x) / ball, (y - circle.y) / ball);
        samples.push_back(sample(i, x, y, n, true, step));
      });
    }
    return samples;
  }

  // Free gel: all near the rim, ever fewer outwards, where much of the same is.
  [[nodiscard]] std::vector<FitSample> free_samples(double length, std::uint32_t thinning) const {
    std::vector<FitSample> samples;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (!entries_[i].report.fits) continue;
      options_.cancelled.check(done_, "fitting the bulge");
      const Circle& circle = entries_[i].report.contact;
      const double most = std::min(4 * circle.radius, farthest_corner(circle));
      const BallSurface surface(circle.radius, presses_[i].ball_radius, length, most);
      for_pixels(circle, circle.radius, most, [&](Index x, Index y) {
        const double dx = x - circle.x, dy = y - circle.y, near = 1.7 * circle.radius;
        const std::uint32_t step = thinning * (dx * dx + dy * dy < near * near ? 5 : 11);
        if (scattered(x, y) % step != 0) return;
        samples.push_back(sample(i, x, y, surface.normal(dx, dy), false, step));
      });
    }
    return samples;
  }

  // A number that has no pattern along the image.
  [[nodiscard]] static std::uint32_t scattered(Index x, Index y) {
    std::uint32_t h =
        static_cast<std::uint32_t>(x) * 0x9e3779b1u ^ static_cast<std::uint32_t>(y) * 0x85ebca77u;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    return h ^ h >> 13;
  }

  // --- touched gel -------------------------------------------------------------------------------

  void fit_touched(bool is_last, const CancelHook& cancelled) {
    const std::vector<FitSample> samples = touched_samples();
    switch (options_.model) {
      case ReflectanceModel::lights:
        return fit_lights(samples, is_last, cancelled);
      case ReflectanceModel::polynomial:
        return fit_linear(PolynomialReflectance{options_.polynomial_degree, reach_, {}, {}},
                          samples, is_last, cancelled);
      case ReflectanceModel::table:
        return fit_linear(TableReflectance{options_.table_nodes, reach_, {}, {}}, samples, is_last,
                          cancelled);
    }
  }

  void fit_lights(const std::vector<FitSample>& samples, bool is_last,
                  const CancelHook& cancelled) {
    std::vector<FitSample> few;
    const std::size_t step = std::max<std::size_t>(1, samples.size() / most_light_samples);
    for (std::size_t k = 0; k < samples.size(); k += step) few.push_back(samples[k]);
    const double height = double{1} * background_.height() / background_.width();
    const auto* const known = std::get_if<LightsReflectance>(&result_.sensor.reflectance);
    const LightsReflectance start = known != nullptr && !known->lights.empty()
                                        ? *known
                                        : LightsFit::lights_around(options_.lights, height);
    result_.sensor.reflectance = LightsFit(few, start).solve(is_last ? 1e-4 : 1e-3, cancelled);
  }

  template <class Model>
  [[nodiscard]] std::vector<NormalEquations> grouped(const Model& model,
                                                     const std::vector<FitSample>& samples) const {
    const std::size_t groups = std::min<std::size_t>(3, entries_.size());
    std::vector<NormalEquations> all(groups, NormalEquations(model.size()));
    TermRow row;
    for (const FitSample& s : samples) {
      row.fill(model, s.point);
      all[static_cast<std::size_t>(s.press) % groups].add(row, s.change, s.weight);
    }
    return all;
  }

  template <class Model>
  void fit_linear(Model model, const std::vector<FitSample>& samples, bool is_last,
                  const CancelHook& cancelled) {
    const std::vector<NormalEquations> groups = grouped(model, samples);
    NormalEquations all = groups[0];
    for (std::size_t g = 1; g < groups.size(); ++g) all.add(groups[g]);
    if (!is_smoothness_chosen_) choose_smoothness(model, groups, all, cancelled);
    model.touched = flat(solve_smooth(model, all, result_.smoothness, false));
    model.free.assign(model.touched.size(), 0.0);
    if (is_last && entries_.size() >= few_presses) keep_spread(model, groups, all);
    result_.sensor.reflectance = std::move(model);
  }

  template <class Model>
  void keep_spread(const Model& model, const std::vector<NormalEquations>& groups,
                   const NormalEquations& all) {
    std::vector<std::vector<double>> solutions;
    for (const NormalEquations& left_out : groups) {
      NormalEquations others = all;
      others.add(left_out, -1);
      solutions.push_back(flat(solve_smooth(model, others, result_.smoothness, false)));
    }
    const auto count = static_cast<double>(groups.size());
    result_.spread.clear();
    for (std::size_t i = 0; i < solutions[0].size(); ++i) {
      double mean = 0, squares = 0;
      for (const auto& one : solutions) mean += one[i] / count;
      for (const auto& one : solutions) squares += (one[i] - mean) * (one[i] - mean);
      result_.spread.push_back(std::sqrt(squares * (count - 1) / count));
    }
  }

  // Of a few, the one whose predictions of presses that were left out are the best.
  template <class Model>
  void choose_smoothness(const Model& model, const std::vector<NormalEquations>& groups,
                         const NormalEquations& all, const CancelHook& cancelled) {
    is_smoothness_chosen_ = true;
    result_.smoothness = {10, 10};
    if (entries_.size() < few_presses) return;
    double least = std::numeric_limits<double>::infinity(), solved = 0;
    const auto attempt = [&](const Smoothness& smoothness) {
      double squares = 0;
      for (const NormalEquations& held_out : groups) {
        cancelled.check(solved++ / (8.0 * static_cast<double>(groups.size())),
                        "choosing the smoothness");
        if (held_out.weight == 0) continue;
        NormalEquations others = all;
        others.add(held_out, -1);
        squares += held_out.residual(solve_smooth(model, others, smoothness, false));
      }
      if (!(squares < least)) return;
      least = squares;
      result_.smoothness = smoothness;
    };
    for (const double along_place : {1.0, 3.0, 10.0, 30.0}) attempt({3, along_place});
    const double best = result_.smoothness.place;
    for (const double along_normal : {0.3, 1.0, 10.0, 30.0}) attempt({along_normal, best});
    result_.held_out = unit_background * std::sqrt(least / (3 * all.weight));
  }

  // --- circles -----------------------------------------------------------------------------------

  void refine_all(const CancelHook& cancelled) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      cancelled.check(static_cast<double>(i) / static_cast<double>(entries_.size()),
                      "refining the circles");
      refine(i);
    }
    centre_shifts();
  }

  void refine(std::size_t i) {
    Entry& entry = entries_[i];
    const BallPress& press = presses_[i];
    const auto squares_of = [&](const Circle& circle, auto&& use) {
      for_pixels(entry.report.contact, -1, 0.95 * entry.report.contact.radius,
                 [&](Index x, Index y) {
                   if (scattered(x, y) % 3 != 0) return;
                   GelPoint p = place(x, y);
                   p.nx = (x - circle.x) / press.ball_radius;
                   p.ny = (y - circle.y) / press.ball_radius;
                   p.touched = true;
                   use(x, y, change(result_.sensor.reflectance, p));
                 });
    };
    refine_centre(entry, press, squares_of);
  }

  template <class Predict>
  void refine_centre(Entry& entry, const BallPress& press, const Predict& predict) {
    Circle circle = entry.report.contact;
    Normal2 normal;
    for (int step = 0; step < 3; ++step) {
      std::vector<Change> left, right, up, down;
      constexpr double h = 0.5;
      const auto store = [](std::vector<Change>& to) {
        return [&to](Index, Index, const Change& c) { to.push_back(c); };
      };
      predict({circle.x - h, circle.y, circle.radius}, store(left));
      predict({circle.x + h, circle.y, circle.radius}, store(right));
      predict({circle.x, circle.y - h, circle.radius}, store(up));
      predict({circle.x, circle.y + h, circle.radius}, store(down));
      normal = {};
      double squares = 0;
      std::size_t k = 0;
      predict(circle, [&](Index x, Index y, const Change& now) {
        for (std::size_t c = 0; c < 3; ++c) {
          const double b = background_level(background_, x, y, c);
          const double off =
              press.photograph(x, y)[c] - background_(x, y)[c] - entry.report.level[c] - b * now[c];
          normal.add(b * (right[k][c] - left[k][c]) / (2 * h),
                     b * (down[k][c] - up[k][c]) / (2 * h), off);
          squares += off * off;
        }
        ++k;
      });
      normal.divide(alike * squares / std::max(1.0, 3.0 * static_cast<double>(k)));
      const double sure = 1 / (mark_error_ * mark_error_);
      normal.pull(sure, entry.marked.x - circle.x, entry.marked.y - circle.y);
      const Vec2<double> move = normal.solution();
      circle.x += std::clamp(move.x(), -2.0, 2.0);
      circle.y += std::clamp(move.y(), -2.0, 2.0);
    }
    entry.report.contact = circle;
    entry.report.doubt = {std::sqrt(normal.yy / normal.determinant()),
                          std::sqrt(normal.xx / normal.determinant())};
  }

  // Normal equations of a shift.
  struct Normal2 {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;

    void add(double by_x, double by_y, double off) {
      xx += by_x * by_x;
      xy += by_x * by_y;
      yy += by_y * by_y;
      x += off * by_x;
      y += off * by_y;
    }
    void divide(double by) {
      if (!(by > 0)) return;
      for (double* value : {&xx, &xy, &yy, &x, &y}) *value /= by;
    }
    void pull(double weight, double to_x, double to_y) {
      xx += weight;
      yy += weight;
      x += weight * to_x;
      y += weight * to_y;
    }
    [[nodiscard]] double determinant() const { return xx * yy - xy * xy; }
    [[nodiscard]] Vec2<double> solution() const {
      return {(yy * x - xy * y) / determinant(), (xx * y - xy * x) / determinant()};
    }
  };

  // A shift of all circles alike is one of the table, which photographs cannot tell: the marks are
  // taken to be right on average. How far they are off each tells how far the next round may go.
  void centre_shifts() {
    Vec2<double> mean(0, 0);
    const auto count = static_cast<double>(entries_.size());
    const auto shift = [](const Entry& e) {
      return Vec2<double>(e.report.contact.x - e.marked.x, e.report.contact.y - e.marked.y);
    };
    for (const Entry& e : entries_) mean += shift(e) / count;
    double squares = 0;
    for (Entry& e : entries_) {
      e.report.contact.x -= mean.x();
      e.report.contact.y -= mean.y();
      squares += squared_norm(shift(e)) / (2 * count);
    }
    mark_error_ = std::clamp(std::sqrt(squares), 0.2, 4.0);
  }

  void leave_out() {
    std::vector<double> residuals;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      residuals.push_back(inside_residual(i, entries_[i].report.contact));
    }
    std::vector<double> sorted = residuals;
    std::nth_element(sorted.begin(),
                     sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double median = sorted[sorted.size() / 2];
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      entries_[i].report.fits = residuals[i] <= 2.5 * median + 0.5;
    }
  }

  // --- free gel ----------------------------------------------------------------------------------

  void fit_free() {
    if (options_.bulge_length > 0) {
      result_.sensor.bulge_length = options_.bulge_length;
      (void)free_squares(options_.bulge_length, 1);
      return;
    }
    double radius = 0;
    for (const Entry& e : entries_)
      radius += e.report.contact.radius / static_cast<double>(entries_.size());
    // By golden section over the logarithm, and then a parabola.
    const double golden = 0.6180339887498949;
    double low = std::log(0.05 * radius);
    double high = std::log(std::min(2.5 * radius, 0.8 * longest_bulge));
    double a = high - golden * (high - low), b = low + golden * (high - low);
    double at_a = free_squares(std::exp(a)), at_b = free_squares(std::exp(b));
    for (int step = 0; step < 5; ++step) {
      done_ = half + 0.06 * step;
      if (at_a < at_b) {
        high = b;
        b = a;
        at_b = at_a;
        a = high - golden * (high - low);
        at_a = free_squares(std::exp(a));
      } else {
        low = a;
        a = b;
        at_a = at_b;
        b = low + golden * (high - low);
        at_b = free_squares(std::exp(b));
      }
    }
    const double middle = at_a < at_b ? a : b, least = std::min(at_a, at_b), h = 0.2;
    const double below = free_squares(std::exp(middle - h));
    const double above = free_squares(std::exp(middle + h));
    const double curvature = (below - 2 * least + above) / (h * h);
    const double shift = curvature > 0 ? (below - above) / (2 * h * curvature) : 0;
    result_.sensor.bulge_length = std::exp(middle + std::clamp(shift, -h, h));
    result_.bulge_doubt = curvature > 0
                              ? result_.sensor.bulge_length *
                                    std::sqrt(2 * alike * least / (3 * free_weight_ * curvature))
                              : std::numeric_limits<double>::infinity();
    (void)free_squares(result_.sensor.bulge_length, 1);
  }

  // Fits free gel with a bulge of this length; returns what squares are left.
  [[nodiscard]] double free_squares(double length, std::uint32_t thinning = 5) {
    const std::vector<FitSample> samples = free_samples(length, thinning);
    free_weight_ = 0;
    for (const FitSample& s : samples) free_weight_ += s.weight;
    return std::visit([&](auto& model) { return fit_free_gel(model, samples); },
                      result_.sensor.reflectance);
  }

  template <class Model>
  [[nodiscard]] double fit_free_gel(Model& model, const std::vector<FitSample>& samples) {
    NormalEquations all(model.size());
    TermRow row;
    for (const FitSample& s : samples) {
      row.fill(model, s.point);
      all.add(row, s.change, s.weight);
    }
    const Eigen::MatrixXd solution = solve_smooth(model, all, {1, 3}, true);
    model.free = flat(solution);
    return all.residual(solution);
  }

  [[nodiscard]] double fit_free_gel(LightsReflectance& model,
                                    const std::vector<FitSample>& samples) {
    model.free_share = {1, 1, 1};
    Change product{}, square{}, own{};
    for (const FitSample& s : samples) {
      const Change whole = change(model, s.point);
      for (std::size_t c = 0; c < 3; ++c) {
        product[c] += s.weight * whole[c] * s.change[c];
        square[c] += s.weight * whole[c] * whole[c];
        own[c] += s.weight * s.change[c] * s.change[c];
      }
    }
    double left = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      model.free_share[c] = square[c] > 0 ? product[c] / square[c] : 1;
      left += own[c] - model.free_share[c] * product[c];
    }
    return left;
  }

  // --- report ------------------------------------------------------------------------------------

  // Over the pixels and channels of a region in one photograph.
  struct RegionSum {
    double signal = 0, residual = 0, count = 0;
  };

  [[nodiscard]] double inside_residual(std::size_t i, const Circle& circle) const {
    const RegionSum sum = region_sum(i, circle, -1, 0.9 * circle.radius, nullptr);
    return sum.residual / std::max(1.0, sum.count);
  }

  [[nodiscard]] RegionSum region_sum(std::size_t i, const Circle& circle, double from, double to,
                                     const BallSurface* surface) const {
    RegionSum sum;
    for_pixels(circle, from, to, [&](Index x, Index y) {
      const double dx = x - circle.x, dy = y - circle.y;
      GelPoint p = place(x, y);
      p.touched = dx * dx + dy * dy <= circle.radius * circle.radius;
      const Vec2<double> n = surface == nullptr ? Vec2<double>(dx / presses_[i].ball_radius,
                                                               dy / presses_[i].ball_radius)
                                                : surface->normal(dx, dy);
      p.nx = n.x();
      p.ny = n.y();
      const bool is_flat = n.isZero() && !p.touched;
      const Change model = is_flat ? Change{} : change(result_.sensor.reflectance, p);
      for (std::size_t c = 0; c < 3; ++c) {
        const double seen =
            presses_[i].photograph(x, y)[c] - background_(x, y)[c] - entries_[i].report.level[c];
        sum.signal += std::abs(seen);
        sum.residual += std::abs(seen - background_level(background_, x, y, c) * model[c]);
      }
      sum.count += 3;
    });
    return sum;
  }

  void report() {
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<double> levels;
      for (const Entry& e : entries_) levels.push_back(e.report.level[c]);
      std::sort(levels.begin(), levels.end());
      const std::size_t n = levels.size();
      result_.sensor.level[c] = (levels[n / 2] + levels[(n - 1) / 2]) / 2;
    }
    struct Ring {
      const char* name;
      double from, to;  // contact radii
    };
    constexpr std::array<Ring, 5> rings{{{"apex", -1, 0.4},
                                         {"flank", 0.4, 0.9},
                                         {"rim", 0.9, 1.1},
                                         {"bulge", 1.1, 2.5},
                                         {"far", 2.5, 1e9}}};
    std::vector<BallSurface> surfaces;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      options_.cancelled.check(done_, "the calibration's report");
      const Circle& circle = entries_[i].report.contact;
      surfaces.emplace_back(circle.radius, presses_[i].ball_radius, result_.sensor.bulge_length,
                            farthest_corner(circle));
    }
    for (const Ring& ring : rings) {
      RegionResidual mean{ring.name, 0, 0};
      double seen = 0;  // photographs in which there is some of the ring
      for (std::size_t i = 0; i < entries_.size(); ++i) {
        const Circle& circle = entries_[i].report.contact;
        const RegionSum sum = region_sum(i, circle, ring.from < 0 ? -1 : ring.from * circle.radius,
                                         std::min(1e5, ring.to * circle.radius), &surfaces[i]);
        if (sum.count == 0) continue;
        mean.signal += sum.signal / sum.count;
        mean.residual += sum.residual / sum.count;
        ++seen;
      }
      mean.signal /= std::max(1.0, seen);
      mean.residual /= std::max(1.0, seen);
      result_.regions.push_back(mean);
    }
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      PressReport& press = entries_[i].report;
      press.residual = inside_residual(i, press.contact);
      if (!press.fits) {
        result_.warnings.push_back(joined(press.name, " does not fit the others (residual ",
                                          two_decimals(press.residual),
                                          " grey levels) and was left out"));
      }
      result_.presses.push_back(press);
    }
  }

  // Fewer tell neither how smooth a reflectance is nor which of their circles is off.
  static constexpr std::size_t few_presses = 5;
  static constexpr double half = 0.5;  // of the work
  // Residuals are alike over some pixels each way, so that so many count as one.
  static constexpr double alike = 30;
  static constexpr double unit_background = 128, most_samples = 40000;
  static constexpr std::size_t most_light_samples = 2500;

  const Image<Rgb8>& background_;
  std::span<const BallPress> presses_;
  const CalibrationOptions& options_;
  std::vector<Entry> entries_;
  double reach_ = 0, mark_error_ = 2, free_weight_ = 0;
  double done_ = half;  // of the work, when the bulge is fitted
  bool is_smoothness_chosen_ = false;
  Calibration result_;
};

}  // namespace detail

GELIGHT_INLINE Calibration calibrate(const Image<Rgb8>& background,
                                     std::span<const BallPress> presses,
                                     const CalibrationOptions& options) {
  return detail::Calibrator(background, presses, options).solve();
}

GELIGHT_INLINE Image<std::array<double, 3>> predict(const CalibratedSensor& sensor,
                                                    const Circle& contact, double ball_radius,
                                                    const Change& level) {
  detail::require_sensor(sensor);
  detail::require(std::isfinite(contact.x) && std::isfinite(contact.y), "a circle at (", contact.x,
                  ", ", contact.y, ")");
  for (const double by : level) {
    detail::require(std::isfinite(by), "a photograph brighter by ", by, " grey levels");
  }
  const Index width = sensor.background.width(), height = sensor.background.height();
  const detail::BallSurface surface(contact.radius, ball_radius, sensor.bulge_length,
                                    detail::farthest_corner(contact, sensor.background));
  Image<std::array<double, 3>> out(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double dx = x - contact.x, dy = y - contact.y;
      const Vec2<double> n = surface.normal(dx, dy);
      const GelPoint p{n.x(), n.y(), 2.0 * x / (width - 1) - 1, 2.0 * y / (height - 1) - 1,
                       dx * dx + dy * dy <= contact.radius * contact.radius};
      const Change by = n.isZero() && !p.touched ? Change{} : change(sensor.reflectance, p);
      for (std::size_t c = 0; c < 3; ++c) {
        detail::require(std::isfinite(by[c]), "the reflectance changes pixel (", x, ", ", y,
                        ") by ", by[c]);
        out(x, y)[c] = sensor.background(x, y)[c] + level[c] +
                       detail::background_level(sensor.background, x, y, c) * by[c];
      }
    }
  }
  return out;
}

GELIGHT_INLINE double rim_height(double contact_radius, double ball_radius, double length) {
  const double slope = detail::slope_at_rim(contact_radius, ball_radius);
  detail::require_bulge(length);
  if (length == 0) return 0;
  const auto k = detail::scaled_bessel_k(contact_radius / length);
  return slope * length * k.k0 / k.k1;
}

}  // namespace gelight
