#include "gelight/sensor/calibrated.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <string>
#include <variant>
#include <vector>

#include "gelight/membrane/tension.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using gelight::test::contains;
using gelight::test::refusal;

namespace {

constexpr Index width = 160, height = 120;
constexpr double ball = 30;

Image<Rgb8> gradient() {
  Image<Rgb8> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(110 + x / 8), static_cast<std::uint8_t>(120 - y / 6),
                     104};
    }
  }
  return image;
}

// One of each kind, without light at rest.
std::vector<FittedReflectance> reflectances() {
  LightsReflectance lights;
  lights.height = 0.75;
  lights.softness = 0.4;
  lights.contact = {0.02, -0.03, 0.01};
  lights.lights = {{{1.5, 0.2, 0.9}, {0.5, 0.1, 0}, {0.1, 0.1, 0.1}},
                   {{-1, 1.2, 0.8}, {0, 0.4, 0.2}, {0, 0, 0}},
                   {{-0.8, -1.4, 1}, {0.1, 0, 0.5}, {0, 0, 0}}};
  PolynomialReflectance polynomial{2, 0.9, std::vector<double>(108), std::vector<double>(108)};
  for (std::size_t i = 18; i < 108; ++i) {
    polynomial.touched[i] = 0.2 * std::sin(static_cast<double>(i));
    polynomial.free[i] = 0.2 * std::cos(static_cast<double>(i));
  }
  TableReflectance table{5, 0.9, std::vector<double>(450), std::vector<double>(450)};
  for (std::size_t i = 0; i < 450; ++i) {
    table.touched[i] = 0.1 * std::sin(static_cast<double>(i));
    if (i < 12 * 18 || i >= 13 * 18) table.free[i] = 0.1 * std::cos(static_cast<double>(i));
  }
  return {lights, polynomial, table};
}

// What each pixel shows of a ball by the normals' own formulas.
Image<std::array<double, 3>> predicted(const CalibratedSensor& sensor, double cx, double cy,
                                       double contact) {
  Image<std::array<double, 3>> out(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double dx = x - cx, dy = y - cy, r = std::max(1e-9, std::hypot(dx, dy));
      const double rim = contact / std::sqrt(ball * ball - contact * contact);
      const double slope =
          r <= contact ? r / std::sqrt(ball * ball - r * r)
                       : rim * std::cyl_bessel_k(1.0, r / 9) / std::cyl_bessel_k(1.0, contact / 9);
      const double tilt = slope / std::sqrt(1 + slope * slope) / r;
      const Change by = change(sensor.reflectance, {tilt * dx, tilt * dy, 2.0 * x / (width - 1) - 1,
                                                    2.0 * y / (height - 1) - 1, r <= contact});
      for (std::size_t c = 0; c < 3; ++c) {
        out(x, y)[c] = std::clamp(sensor.background(x, y)[c] * (1 + by[c]), 0.0, 255.0);
      }
    }
  }
  return out;
}

// As in many languages: 1.234,5.
struct PointsForThousands : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// All numbers of a reflectance.
std::vector<double> numbers(const FittedReflectance& reflectance) {
  if (const auto* const m = std::get_if<LightsReflectance>(&reflectance)) {
    std::vector<double> all{m->softness, m->falloff, m->shininess, m->height};
    const auto add = [&](const auto& three) {
      for (std::size_t i = 0; i < 3; ++i) all.push_back(three[static_cast<Index>(i)]);
    };
    for (const NearLight& light : m->lights) {
      add(light.place);
      all.insert(all.end(), light.diffuse.begin(), light.diffuse.end());
      all.insert(all.end(), light.specular.begin(), light.specular.end());
    }
    for (const Change& three : {m->ambient, m->contact, m->free_share}) {
      all.insert(all.end(), three.begin(), three.end());
    }
    return all;
  }
  const auto of = [](const auto& m) {
    std::vector<double> all{m.reach};
    all.insert(all.end(), m.touched.begin(), m.touched.end());
    all.insert(all.end(), m.free.begin(), m.free.end());
    return all;
  };
  if (const auto* const m = std::get_if<TableReflectance>(&reflectance)) return of(*m);
  return of(std::get<PolynomialReflectance>(reflectance));
}

}  // namespace

TEST_CASE("a sensor's file brings its numbers back to the last bit, whatever the locale") {
  const std::string path =
      (std::filesystem::temp_directory_path() / "calibrated_bits_test.sensor").string();
  std::vector<FittedReflectance> all = reflectances();
  all.emplace_back(LightsReflectance{});  // without a light
  for (const FittedReflectance& reflectance : all) {
    Image<Rgb8> wide(1200, 3, {1, 2, 3});
    wide(7, 1) = {10, 13, 32};
    const CalibratedSensor made{wide, reflectance, 1000 / 7.0, {1 / 3.0, -2e-9, 1e5 / 3}};
    const std::locale before =
        std::locale::global(std::locale(std::locale::classic(), new PointsForThousands));
    write_sensor(path, made);
    std::locale::global(before);
    const CalibratedSensor sensor = read_sensor(path);
    CHECK(sensor.background == made.background);
    CHECK(sensor.bulge_length == made.bulge_length);
    CHECK(sensor.level == made.level);
    CHECK(numbers(sensor.reflectance) == numbers(made.reflectance));
  }
  std::filesystem::remove(path);
}

TEST_CASE(
    "a reflectance without its numbers, or with what is none, is refused by whoever reads it") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto table = std::get<TableReflectance>(reflectances()[2]);
  const auto polynomial = std::get<PolynomialReflectance>(reflectances()[1]);
  const auto lights = std::get<LightsReflectance>(reflectances()[0]);
  std::vector<FittedReflectance> bad;
  const auto spoilt = [&](auto model, auto&& spoil) {
    spoil(model);
    bad.emplace_back(model);
  };
  spoilt(TableReflectance{}, [](auto&) {});
  spoilt(table, [](auto& m) { m.touched.pop_back(); });
  spoilt(table, [](auto& m) { m.free.push_back(0); });
  spoilt(table, [](auto& m) { m.nodes = 7; });
  spoilt(table, [](auto& m) { m.nodes = -5; });
  spoilt(table, [](auto& m) { m.reach = 0; });
  spoilt(table, [&](auto& m) { m.free[99] = nan; });
  spoilt(polynomial, [](auto& m) { m.degree = 9; });
  spoilt(polynomial, [](auto& m) { m.degree = -1; });
  spoilt(polynomial, [&](auto& m) { m.touched[3] = nan; });
  spoilt(polynomial, [&](auto& m) { m.reach = nan; });
  spoilt(lights, [](auto& m) { m.softness = 0; });
  spoilt(lights, [](auto& m) { m.shininess = -1; });
  spoilt(lights, [&](auto& m) { m.lights[1].place.y() = nan; });
  const std::string path =
      (std::filesystem::temp_directory_path() / "calibrated_bad_test.sensor").string();
  std::filesystem::remove(path);  // of a run that failed
  for (const FittedReflectance& reflectance : bad) {
    const CalibratedSensor sensor{gradient(), reflectance, 9, {}};
    const std::string told = refusal([&] { write_sensor(path, sensor); });
    CHECK(told != "accepted");
    CHECK(!std::filesystem::exists(path));
    CHECK(refusal([&] { (void)CalibratedReflectance<float>(sensor); }) == told);
    CHECK(refusal([&] { (void)predict(sensor, {50, 50, 10}, 30); }) == told);
  }
}

TEST_CASE(
    "a circle that is none of the ball's, and an endless bulge, are refused rather than tried") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  CalibratedSensor sensor{gradient(), reflectances()[0], 9, {}};
  const auto refused = [&](const Circle& circle, double radius) {
    return refusal([&] { (void)predict(sensor, circle, radius); }) != "accepted";
  };
  CHECK(refused({50, 50, 10}, 10));
  CHECK(refused({50, 50, 10}, 5));
  CHECK(refused({50, 50, 10}, 0));
  CHECK(refused({50, 50, 10}, -30));
  CHECK(refused({50, 50, 10}, nan));
  CHECK(refused({50, 50, 10}, infinity));
  CHECK(refused({50, 50, -1}, 30));
  CHECK(refused({50, 50, nan}, 30));
  CHECK(refused({nan, 50, 10}, 30));
  CHECK(!refused({50, 50, 0}, 30));
  // However far off it is, such a contact is not seen.
  for (const double far : {1e4, 1e19, 1e20, 1e160}) {
    const auto seen = predict(sensor, {far, 50, 10}, 30);
    for (std::size_t c = 0; c < 3; ++c) CHECK(seen(5, 5)[c] == gradient()(5, 5)[c]);
  }
  CHECK(!refused({50, 50, std::nextafter(30.0, 0.0)}, 30));  // nearly upright at the rim
  for (const double length : {1e5, 1e300, infinity, nan, -1.0}) {
    sensor.bulge_length = length;
    CHECK(refused({50, 50, 10}, 30));
    CHECK(refusal([&] { (void)rim_height(10, 30, length); }) != "accepted");
  }
  CHECK(rim_height(10, 30, 0) == 0);
  CHECK(refusal([] { (void)rim_height(30, 30, 5); }) ==
        "a ball of radius 30 touches in a circle of radius 30");
}

TEST_CASE("the renderer makes of a sensor's file what the fit predicts") {
  const std::string path =
      (std::filesystem::temp_directory_path() / "calibrated_test.sensor").string();
  for (const FittedReflectance& reflectance : reflectances()) {
    const CalibratedSensor made{gradient(), reflectance, 9, {1, -2, 3}};
    write_sensor(path, made);
    const CalibratedSensor sensor = read_sensor(path);
    CHECK(sensor.background == made.background);
    CHECK(sensor.bulge_length == 9);
    CHECK(sensor.level == made.level);

    const Camera<double> camera{8000, 8000, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
    const TactileRenderer renderer(camera, Image<double>(width, height, 1),
                                   TensionMembrane<double>(sensor.bulge_length),
                                   CalibratedReflectance<double>(sensor));
    CHECK(renderer.rest_image() == sensor.background);
    const double deep = ball - std::sqrt(ball * ball - 19 * 19) +
                        19 / std::sqrt(ball * ball - 19 * 19) * 9 *
                            std::cyl_bessel_k(0.0, 19 / 9.0) / std::cyl_bessel_k(1.0, 19 / 9.0);
    Image<double> depth(width, height, std::numeric_limits<double>::infinity());
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double left = ball * ball - (x - 70.0) * (x - 70) - (y - 55.0) * (y - 55);
        if (left > 0) depth(x, y) = 1 - (deep - ball + std::sqrt(left)) / 8000;
      }
    }
    const Image<Rgb8> image = renderer.render(depth);
    const auto expected = predicted(sensor, 70, 55, 19);
    double sum = 0;
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum += std::abs(image.pixels()[i][c] - expected.pixels()[i][c]);
      }
    }
    CHECK(sum / (3.0 * width * height) < 0.5);  // rounding is a quarter
  }

  std::ifstream whole(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  for (const double share : {0.0, 0.001, 0.1, 0.5, 0.999}) {
    std::ofstream(path, std::ios::binary)
        << bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size())));
    CHECK(contains(refusal([&] { (void)read_sensor(path); }), path));
  }
  std::filesystem::remove(path);
  CHECK(contains(refusal([&] { (void)read_sensor(path); }), "cannot be opened"));
}

TEST_CASE("a reflectance that is no number at a pixel, or in float, is refused by name") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto lights = std::get<LightsReflectance>(reflectances()[0]);
  const auto table = std::get<TableReflectance>(reflectances()[2]);
  const auto sensor_of = [](const FittedReflectance& model) {
    return CalibratedSensor{gradient(), model, 9, {}};
  };
  // In the gel's surface, at a node of the places: infinitely bright.
  auto within = lights;
  within.lights[1].place = {0, 0, 0};
  auto steep = lights;
  steep.falloff = -1e300;
  for (const LightsReflectance& model : {within, steep}) {
    CHECK(contains(refusal([&] { (void)CalibratedReflectance<double>(sensor_of(model)); }),
                   "of a reflectance's table of touched gel is"));
  }
  CHECK(contains(refusal([&] {
                   (void)predict(sensor_of(steep), {50, 50, 10}, 30);
                 }),
                 "the reflectance changes pixel ("));
  // What double holds, and float does not.
  for (const bool touched : {true, false}) {
    auto model = table;
    (touched ? model.touched : model.free)[99] = -1e37;
    CHECK(refusal([&] { (void)CalibratedReflectance<double>(sensor_of(model)); }) == "accepted");
    CHECK(contains(refusal([&] { (void)CalibratedReflectance<float>(sensor_of(model)); }),
                   touched ? "number 99 of the table of touched gel is -"
                           : "number 99 of the table of free gel is -"));
  }
  auto narrow = table;
  narrow.reach = 1e-100;
  CHECK(refusal([&] { (void)CalibratedReflectance<double>(sensor_of(narrow)); }) == "accepted");
  CHECK(contains(refusal([&] { (void)CalibratedReflectance<float>(sensor_of(narrow)); }),
                 "a table of reach 1e-100"));
  for (std::size_t c = 0; c < 3; ++c) {
    Change level{};
    level[c] = nan;
    CHECK(refusal([&] {
            (void)predict(sensor_of(table), {50, 50, 10}, 30, level);
          }) == "a photograph brighter by nan grey levels");
  }
}

TEST_CASE("where there is no normal the image is the background, touched or not") {
  const Image<Rgb8> background = gradient();
  const std::vector<double> nothing(width, 0), all(width, 1);
  for (const auto& reflectance : reflectances()) {
    const CalibratedReflectance<double> model({background, reflectance});
    for (const auto& touched : {nothing, all}) {
      std::vector<double> r(20), g(20), b(20);
      const double* const zero = nothing.data();
      model.shade_row({r.data(), g.data(), b.data()},
                      {30, 40, 20, zero, zero, zero, nullptr, touched.data()});
      for (std::size_t i = 0; i < 20; ++i) {
        const auto& pixel = background(30 + static_cast<Index>(i), 40);
        CHECK(std::abs(255 * r[i] - pixel[0]) < 0.51);
        CHECK(std::abs(255 * g[i] - pixel[1]) < 0.51);
        CHECK(std::abs(255 * b[i] - pixel[2]) < 0.51);
      }
    }
  }
}
