#include "gelight/sensor/calibrate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gelight/io/presses.hpp"
#include "gelight/sensor/calibration/ball_surface.hpp"
#include "gelight/sensor/calibration/circles.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using gelight::test::contains;
using gelight::test::refusal;

namespace {

constexpr Index width = 160, height = 120;
constexpr double ball = 30, decay = 9;

Image<Rgb8> gradient() {
  Image<Rgb8> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(110 + x / 8), static_cast<std::uint8_t>(120 - y / 6),
                     static_cast<std::uint8_t>(100 + y / 5)};
    }
  }
  return image;
}

// The known sensor: Lambert with three far lights, brighter towards one side; shares of the
// background. The gel's slope outside of the contact by an integral of its own, not the library's.
double true_change(const Vec3<double>& n, double x, std::size_t c) {
  constexpr double azimuth[3] = {0.3, 2.4, 4.5};
  const Vec3<double> light(0.8 * std::cos(azimuth[c]), 0.8 * std::sin(azimuth[c]), 0.6);
  return 0.6 * (1 + 0.2 * (2 * x / (width - 1) - 1)) * (n.dot(light) - light.z());
}

double true_slope(double r, double contact) {
  if (r <= contact) return r / std::sqrt(ball * ball - r * r);
  return contact / std::sqrt(ball * ball - contact * contact) * std::cyl_bessel_k(1.0, r / decay) /
         std::cyl_bessel_k(1.0, contact / decay);
}

BallPress photograph(const Circle& circle, const Change& level, double noise, unsigned seed) {
  BallPress press{"press " + std::to_string(seed), gradient(), circle, ball};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double dx = x - circle.x, dy = y - circle.y, r = std::hypot(dx, dy);
      const double slope = true_slope(std::max(r, 1e-9), circle.radius);
      const double along = slope / std::sqrt(1 + slope * slope) / std::max(r, 1e-9);
      const Vec3<double> n(along * dx, along * dy, 1 / std::sqrt(1 + slope * slope));
      for (std::size_t c = 0; c < 3; ++c) {
        const double background = press.photograph(x, y)[c];
        const double seen =
            background * (1 + true_change(n, x, c)) + level[c] + (noise > 0 ? normal(random) : 0);
        press.photograph(x, y)[c] =
            static_cast<std::uint8_t>(std::clamp(std::lround(seen), 0L, 255L));
      }
    }
  }
  return press;
}

std::vector<BallPress> presses(double noise, unsigned seed, int count = 8) {
  std::vector<BallPress> all;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < count; ++i) {
    const Circle circle{35 + 90 * share(random), 30 + 60 * share(random), 17 + 5 * share(random)};
    all.push_back(photograph(circle, {8 * share(random) - 4, 0, 5 * share(random)}, noise,
                             seed * 100 + static_cast<unsigned>(i)));
  }
  return all;
}

CalibrationOptions options_of(ReflectanceModel model) {
  CalibrationOptions options;
  options.model = model;
  return options;
}

// For what is said of photographs, a coarse table will do, and takes a fifth of the time.
CalibrationOptions few_nodes() {
  CalibrationOptions options;
  options.table_nodes = 7;
  return options;
}

// Mean absolute grey levels within 0.9 of the contact, against a press without noise.
double error_inside(const CalibratedSensor& sensor, const Circle& circle) {
  const BallPress truth = photograph(circle, {}, 0, 1);
  const auto ours = predict(sensor, circle, ball);
  double sum = 0, count = 0;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if (std::hypot(x - circle.x, y - circle.y) > 0.9 * circle.radius) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        sum += std::abs(ours(x, y)[c] - truth.photograph(x, y)[c]);
        ++count;
      }
    }
  }
  return sum / count;
}

}  // namespace

TEST_CASE("a known sensor is recovered by every model, in spite of noise") {
  const Circle unseen{80.5, 60.25, 19};
  for (const unsigned seed : {1u}) {
    const auto known = presses(2, seed);
    for (const auto model :
         {ReflectanceModel::lights, ReflectanceModel::polynomial, ReflectanceModel::table}) {
      CAPTURE(seed);
      CAPTURE(static_cast<int>(model));
      const Calibration fit = calibrate(gradient(), known, options_of(model));
      // Rounding alone is 0.25 grey levels; the signal is some twenty.
      CHECK(error_inside(fit.sensor, unseen) < 1);
      CHECK(std::abs(fit.sensor.bulge_length / decay - 1) < 0.15);
      CHECK(fit.bulge_doubt > 0.001 * decay);
      CHECK(fit.bulge_doubt < 0.15 * decay);
      CHECK(fit.warnings.empty());
      CHECK(fit.regions.size() == 5);
      CHECK(fit.spread.empty() == (model == ReflectanceModel::lights));
    }
  }
}

TEST_CASE("each photograph's level of colour is told") {
  std::vector<BallPress> known = presses(1, 3);
  known[4] = photograph(known[4].contact, {20, -10, 5}, 1, 77);
  const Calibration fit = calibrate(gradient(), known, few_nodes());
  CHECK(fit.presses[4].level[0] == gelight::test::approx(20).epsilon(0.05));
  CHECK(fit.presses[4].level[1] == gelight::test::approx(-10).epsilon(0.05));
  CHECK(fit.presses[4].level[2] == gelight::test::approx(5).epsilon(0.1));
  CHECK(fit.presses[4].fits);
}

TEST_CASE("marks that are off are refined, by about what their doubt says") {
  std::vector<BallPress> known = presses(1, 4, 12);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-2.5, 2.5);
  std::vector<Circle> truth;
  double before = 0, after = 0;
  for (BallPress& press : known) {
    truth.push_back(press.contact);
    press.contact.x += off(random);
    press.contact.y += off(random);
  }
  const Calibration fit = calibrate(gradient(), known, few_nodes());
  for (std::size_t i = 0; i < known.size(); ++i) {
    const auto distance = [&](const Circle& c) {
      return std::hypot(c.x - truth[i].x, c.y - truth[i].y);
    };
    before += distance(known[i].contact);
    after += distance(fit.presses[i].contact);
    CHECK(fit.presses[i].doubt.x() > 0);
    CHECK(fit.presses[i].doubt.x() < 1);
  }
  MESSAGE("mean distance from the true centre, pixels: " << before / 12 << " -> " << after / 12);
  CHECK(after < 0.6 * before);
}

TEST_CASE("a circle that is not given is found, and said to be a guess") {
  std::vector<BallPress> known = presses(1, 6);
  const Circle truth = known[2].contact;
  known[2].contact = {};
  const Calibration fit = calibrate(gradient(), known, few_nodes());
  CHECK(fit.presses[2].is_proposed);
  CHECK(std::hypot(fit.presses[2].contact.x - truth.x, fit.presses[2].contact.y - truth.y) < 2);
  CHECK(std::abs(fit.presses[2].contact.radius - truth.radius) < 0.3 * truth.radius);
  REQUIRE(fit.warnings.size() == 1);
  CHECK(contains(fit.warnings[0], known[2].name));
}

// A ball of four hundred pixels, whose image is like that of the small one.
TEST_CASE(
    "the circle of a large ball is found in time for more than one, and the search cancelled") {
  constexpr Index size = 1000;
  const Circle truth{430, 520, 260};
  constexpr double large = 400;
  Image<Rgb8> background(size, size, {120, 120, 120}), photograph = background;
  background(0, 0) = {90, 90, 90};
  for (Index y = 0; y < size; ++y) {
    for (Index x = 0; x < size; ++x) {
      const double dx = (x - truth.x) / large, dy = (y - truth.y) / large;
      if (std::hypot(dx, dy) * large > truth.radius) continue;
      photograph(x, y) = {static_cast<std::uint8_t>(120 + 90 * dx),
                          static_cast<std::uint8_t>(120 - 90 * dy),
                          static_cast<std::uint8_t>(120 + 60 * dy - 60 * dx)};
    }
  }
  int asked = 0;
  const CancelHook hook = [&] {
    ++asked;
    return false;
  };
  const auto found = detail::propose_circle(background, photograph, large, hook).circle;
  CHECK(std::hypot(found.x - truth.x, found.y - truth.y) < 4);
  CHECK(std::abs(found.radius - truth.radius) < 0.05 * truth.radius);
  CHECK(asked > 20);
  const CancelHook stop = [] { return true; };
  CHECK_THROWS_AS((void)detail::propose_circle(background, photograph, large, stop), Cancelled);
}

TEST_CASE("a circle that is searched for is one of its ball, or the photograph is named") {
  int refused = 0;
  for (const double radius : {0.1, 0.7, 1.5, 3.0, 3.2, 4.0, 5.0, 7.0, 8.2, 12.0, 25.0}) {
    std::vector<BallPress> known = presses(1, 10, 1);
    known[0].contact = {};
    known[0].ball_radius = radius;
    CAPTURE(radius);
    const auto told = refusal([&] {
      const auto fit = calibrate(gradient(), known, few_nodes());
      CHECK(fit.presses[0].contact.radius >= 3);
      CHECK(fit.presses[0].contact.radius < radius);
    });
    if (told == "accepted") continue;
    CHECK(contains(told, known[0].name));
    CHECK((contains(told, "at least 3 pixels") || contains(told, "shows no press")));
    ++refused;
  }
  CHECK(refused >= 4);
}

TEST_CASE("a photograph of something else is named and left out") {
  std::vector<BallPress> known = presses(1, 7);
  auto& pixels = known[3].photograph.pixels();
  for (Rgb8& pixel : pixels) std::swap(pixel[0], pixel[2]);
  CalibrationOptions options = few_nodes();
  std::vector<double> done;
  options.cancelled = [&](double share) {
    done.push_back(share);
    return false;
  };
  const Calibration fit = calibrate(gradient(), known, options);
  CHECK(std::is_sorted(done.begin(), done.end()));
  CHECK(done.size() > 30);
  CHECK(done.back() > 0.7);
  CHECK_FALSE(fit.presses[3].fits);
  CHECK(error_inside(fit.sensor, {80, 60, 19}) < 1);
  REQUIRE(fit.warnings.size() == 1);
  CHECK(contains(fit.warnings[0], known[3].name));
}

TEST_CASE("so it is where circles are not refined") {
  for (const int count : {5, 8}) {
    std::vector<BallPress> known = presses(1, 7, count);
    known[3].ball_radius *= 2.5;
    CalibrationOptions options = few_nodes();
    options.refine_circles = false;
    const Calibration fit = calibrate(gradient(), known, options);
    for (std::size_t i = 0; i < known.size(); ++i) CHECK(fit.presses[i].fits == (i != 3));
    REQUIRE(fit.warnings.size() == 1);
    CHECK(contains(fit.warnings[0], known[3].name));
  }
}

TEST_CASE("photographs that show none of a region do not make its residual less") {
  const BallPress small = photograph({80, 60, 17}, {}, 3, 1);
  BallPress large = photograph({80, 60, 45}, {}, 3, 2);  // all of the image is near its contact
  large.ball_radius = 50;
  const auto far = [](const std::vector<BallPress>& all) {
    return calibrate(gradient(), all, few_nodes()).regions[4];
  };
  const RegionResidual alone = far({small}), beside = far({small, large}), none = far({large});
  CHECK(alone.region == "far");
  CHECK(alone.residual > 2);  // the noise
  CHECK(beside.residual == gelight::test::approx(alone.residual).epsilon(0.05));
  CHECK(beside.signal == gelight::test::approx(alone.signal).epsilon(0.05));
  CHECK(none.residual == 0);
}

TEST_CASE("a circle beside which nothing is seen, and a reflectance that is none, are refused") {
  for (const double radius : {120.0, 1e5, 1e8, 1e12, 1e300}) {
    std::vector<BallPress> known = presses(1, 7);
    known[2].contact.radius = radius;
    known[2].ball_radius = 2 * radius;
    const std::string told = refusal([&] { (void)calibrate(gradient(), known, few_nodes()); });
    CHECK(contains(told, known[2].name));
    CHECK(contains(told, "no gel far from it"));
  }
  const auto model = static_cast<ReflectanceModel>(7);
  const std::string told =
      refusal([&] { (void)calibrate(gradient(), presses(1, 7), options_of(model)); });
  CHECK(contains(told, "reflectance model 7"));
}

// Such a rim is as steep as can be, and its slope decays over a hundred thousand pixels.
TEST_CASE("a circle as large as its ball and the longest bulge take as long as the image is wide") {
  const double contact = 60;
  for (const double beyond : {1e-13, 1e-9, 1e-3}) {
    for (const double length : {1e2, detail::longest_bulge}) {
      CAPTURE(beyond);
      CAPTURE(length);
      const double radius = contact * (1 + beyond);
      const detail::BallSurface surface(contact, radius, length, 300);
      CHECK(surface.reach() <= 302);
      const double rim = contact / std::sqrt((radius - contact) * (radius + contact));
      for (double r = contact + 0.5; r <= 300; r += 7.25) {
        const double slope =
            rim * std::cyl_bessel_k(1.0, r / length) / std::cyl_bessel_k(1.0, contact / length);
        const double wanted = slope < 1e-3 ? 0 : slope / std::sqrt(1 + slope * slope);
        CHECK(surface.normal(0.6 * r, 0.8 * r).norm() ==
              gelight::test::approx(wanted).epsilon(2e-3));
      }
    }
  }
}

TEST_CASE("few presses give a smooth answer") {
  for (const int count : {1, 3}) {
    const Calibration fit = calibrate(gradient(), presses(2, 8, count));
    const BallPress unseen = photograph({60, 50, 18}, {}, 0, 1);
    CAPTURE(count);
    CHECK(error_inside(fit.sensor, unseen.contact) < 12);  // of some twenty
  }
}

TEST_CASE("a photograph in which nothing is pressed is named, however noisy and bright it is") {
  const Image<Rgb8> background = gradient();
  for (const std::size_t count : {1u, 3u, 6u}) {
    for (const double noise : {0.0, 1.0, 6.0}) {
      for (const bool is_marked : {true, false}) {
        CAPTURE(count);
        CAPTURE(noise);
        CAPTURE(is_marked);
        auto known = presses(1, 11, static_cast<int>(count));
        BallPress& spoilt = known[count - 1];
        spoilt = photograph(spoilt.contact, {}, 0, 17);
        spoilt.photograph = background;
        std::mt19937 random(3);
        std::normal_distribution<double> normal(12, noise > 0 ? noise : 1);
        for (Rgb8& pixel : spoilt.photograph.pixels()) {
          for (std::uint8_t& level : pixel) {
            level =
                static_cast<std::uint8_t>(level + (noise > 0 ? std::lround(normal(random)) : 0));
          }
        }
        if (!is_marked) spoilt.contact = {};
        const auto told = refusal([&] { (void)calibrate(background, known, few_nodes()); });
        CHECK(contains(told, spoilt.name + " shows no press"));
      }
    }
  }
}

TEST_CASE("a weak press is one, and a circle where nothing is pressed is none") {
  auto known = presses(1, 12, 1);
  known[0] = photograph({60, 60, 6}, {5, -5, 0}, 1, 20);  // its slope is up to a fifth
  CHECK(refusal([&] { (void)calibrate(gradient(), known, few_nodes()); }) == "accepted");
  known[0].contact.x = 130;
  CHECK(contains(refusal([&] { (void)calibrate(gradient(), known, few_nodes()); }),
                 known[0].name + " shows no press"));
}

TEST_CASE("bad input is named") {
  const Image<Rgb8> background = gradient();
  const auto known = presses(0, 9, 2);
  const auto said = [&](auto&& spoil) {
    auto spoilt = known;
    spoil(spoilt[1]);
    return refusal([&] { (void)calibrate(background, spoilt); });
  };
  CHECK(contains(refusal([&] { (void)calibrate(background, {}); }), "no presses"));
  CHECK(contains(said([](BallPress& p) { p.photograph = Image<Rgb8>(10, 10); }), "10 x 10"));
  CHECK(contains(said([](BallPress& p) { p.contact.x = 500; }), "outside of the image"));
  CHECK(contains(said([](BallPress& p) { p.ball_radius = 15; }), "smaller than its circle"));
  CHECK(contains(said([](BallPress& p) { p.ball_radius = -1; }), "not positive"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(said([&](BallPress& p) { p.contact.y = nan; }) ==
        known[1].name + " has contact.y nan, which is not finite");
  CHECK(said([&](BallPress& p) { p.contact.radius = nan; }) ==
        known[1].name + " has contact.radius nan, which is not finite");
  CHECK(contains(said([](BallPress& p) { p.contact.radius = -5; }),
                 known[1].name + " has contact.radius -5, which is not positive"));
  CHECK(contains(said([](BallPress& p) { p.contact.radius = 0; }),
                 known[1].name + " has contact.radius 0, which is not positive"));
  CHECK(contains(said([](BallPress& p) { p.ball_radius = 0; }),
                 known[1].name + " has ball radius 0, which is not positive"));
  CHECK(contains(said([](BallPress& p) { p.photograph = Image<Rgb8>(0, 160); }),
                 known[1].name + " has 0 x 160 pixels"));
  CHECK(contains(said([](BallPress& p) {
                   p.photograph = Image<Rgb8>(width, height, {9, 9, 9});
                 }),
                 "constant"));
  CHECK(contains(said([](BallPress& p) {
                   for (Index i = 0; i < width * height / 2; ++i) {
                     p.photograph.pixels()[static_cast<std::size_t>(i)][1] = 255;
                   }
                 }),
                 "saturated"));
  CHECK(contains(said([](BallPress& p) { p.contact.x = -3; }), known[1].name));
  CHECK(contains(said([](BallPress& p) { p.contact.y = height; }), known[1].name));
  CHECK(contains(said([](BallPress& p) { p.contact.radius = 2; }), "at least 3 pixels"));
  for (const auto& [colour, word] : {std::pair<Rgb8, const char*>{{9, 9, 9}, "constant"},
                                     std::pair<Rgb8, const char*>{{255, 9, 9}, "saturated"}}) {
    Image<Rgb8> spoilt = background;
    std::fill(spoilt.pixels().begin(), spoilt.pixels().end() - 9, colour);
    if (colour[0] == 9) std::fill(spoilt.pixels().end() - 9, spoilt.pixels().end(), colour);
    const std::string told = refusal([&] { (void)calibrate(spoilt, known); });
    CHECK(contains(told, word));
    CHECK(contains(told, "the background"));
  }
  // With no circle, of a ball that the image shows a small part of: not searched for without end.
  for (const double huge : {1e3, 1e9, 1e300}) {
    const std::string told = said([&](BallPress& p) {
      p.contact = {};
      p.ball_radius = huge;
    });
    CHECK(contains(told, known[1].name));
    CHECK(contains(told, "none is searched for"));
  }
  CHECK(said([](BallPress& p) { p.ball_radius = std::nextafter(p.contact.radius, 1e9); }) ==
        "accepted");
  CalibrationOptions endless;
  endless.bulge_length = 1e9;
  CHECK(contains(refusal([&] { (void)calibrate(background, known, endless); }), "a bulge of"));
  CalibrationOptions too_many;
  too_many.lights = 9;
  CHECK(contains(refusal([&] { (void)calibrate(background, known, too_many); }), "9 lights"));
  CalibrationOptions cancelled;
  cancelled.cancelled = [] { return true; };
  CHECK_THROWS_AS((void)calibrate(background, known, cancelled), Cancelled);
}

TEST_CASE("photographs of a sensor foretell those that were held out") {
  for (const auto& [name, most] : {std::pair<std::string, double>{"gelsight_mini", 4.2},
                                   std::pair<std::string, double>{"gelsight", 5.0}}) {
    const std::string folder = std::string(GELIGHT_REAL_DIR) + "/" + name;
    if (!std::filesystem::exists(folder + "/presses.csv")) {
      MESSAGE("skipped: no photographs at " << folder);
      continue;
    }
    const PressFolder all = read_presses(folder);
    std::vector<BallPress> known, unseen;
    for (std::size_t i = 0; i < all.presses.size(); ++i) {
      (i % 4 == 1 ? unseen : known).push_back(all.presses[i]);
    }
    const Calibration fit = calibrate(all.background, known);
    double mean = 0;
    for (const BallPress& press : unseen) {
      // Levelled: less the mean offset from the background beyond 2.5 radii.
      const auto ours = predict(fit.sensor, press.contact, press.ball_radius);
      for (std::size_t c = 0; c < 3; ++c) {
        double level = 0, far = 0, off = 0, inside = 0;
        for (const bool is_level_known : {false, true}) {
          for (Index y = 0; y < ours.height(); ++y) {
            for (Index x = 0; x < ours.width(); ++x) {
              const double r = std::hypot(x - press.contact.x, y - press.contact.y);
              const double d = press.photograph(x, y)[c] - ours(x, y)[c];
              if (!is_level_known && r > 2.5 * press.contact.radius) {
                level += d;
                ++far;
              }
              if (is_level_known && r <= 0.9 * press.contact.radius) {
                off += std::abs(d - level / far);
                ++inside;
              }
            }
          }
        }
        mean += off / inside / (3 * static_cast<double>(unseen.size()));
      }
    }
    MESSAGE(name << ": " << mean << " grey levels");
    CHECK(mean < most);
  }
}
