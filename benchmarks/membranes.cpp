// What each membrane model is off from the converged elastic layer, and what it takes: as JSON that
// plot/charts.py draws, a row for each gel and model, the mean over four shapes (a ball, an edge, a
// grating, two points).
//
//     membranes COMMIT > membranes.json
//
// A row's name is gel / Poisson ratio / family / model. Errors are those within 2.5 contact radii:
//   surface   root mean square of its depth, in percent of the press
//   normals   mean angle, in degrees
//   levels    mean grey levels, over three channels, of an image with three lights
//   pressure  sum of what is wrong over the sum of all, in percent; where the model tells any
// ms is processor time of a press that nothing came before, all models in turns, the median of
// several.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/image/fast_gaussian.hpp"
#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/run.hpp"
#include "support/timing.hpp"

namespace {

using namespace gelight;
using bench::median;

constexpr double rest = 0.03, pitch = 1e-4, press_depth = 3;
constexpr double inf = std::numeric_limits<double>::infinity();
constexpr Index width = 320, height = 240;
const Camera<double> eye{rest / pitch, rest / pitch, 159.5, 119.5, width, height};

struct Shape {
  double radius;  // of the contact, roughly
  std::function<double(double, double)> overlap;
};

// What a model says of a press; no pressure where it tells none.
struct Answer {
  Image<double> surface, pressure;
};

struct Model {
  std::string name;
  std::function<Answer()> press;
};

// The layer's answer, and what it looks like.
struct Truth {
  Image<double> surface, pressure;
  Image<Rgb8> image;
  double reach;
};

// Of one model and shape.
struct Error {
  double surface = 0, normals = 0, levels = 0, pressure = 0;
};

bool is_near(Index x, Index y, double reach) { return std::hypot(x - 159.5, y - 119.5) <= reach; }

Vec3<double> normal(const Image<double>& z, Index x, Index y) {
  return Vec3<double>((z(x + 1, y) - z(x - 1, y)) / (2 * pitch),
                      (z(x, y + 1) - z(x, y - 1)) / (2 * pitch), 1)
      .normalized();
}

// A surface in the light of three lamps, red, green and blue, that stand around it.
Image<Rgb8> photograph(const Image<double>& surface) {
  using Follows = GaussianMembrane<double>;
  static const TactileRenderer<double> renderer = [] {
    PhongLights<double> lamps{{}, Background<double>(Rgb8{128, 128, 128})};
    for (const std::size_t k : {0u, 1u, 2u}) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / 3;
      Light<double> light{Image<Vec3<double>>(
          width, height, Vec3<double>(std::cos(angle), std::sin(angle), 1).normalized())};
      light.rgb = {0, 0, 0};
      light.rgb[k] = 1;
      lamps.lights.push_back(std::move(light));
    }
    return TactileRenderer<double>(eye, Image<double>(width, height, rest), Follows(0, 0, false),
                                   std::move(lamps));
  }();
  return renderer.render(surface);
}

Error compare(const Answer& answer, const Truth& truth) {
  Error error;
  const Image<Rgb8> image = photograph(answer.surface);
  double count = 0, pressure = 0;
  for (Index y = 1; y < height - 1; ++y) {
    for (Index x = 1; x < width - 1; ++x) {
      if (!is_near(x, y, truth.reach)) continue;
      ++count;
      const double off = (answer.surface(x, y) - truth.surface(x, y)) / (press_depth * pitch);
      error.surface += off * off;
      const double cosine = normal(answer.surface, x, y).dot(normal(truth.surface, x, y));
      error.normals += std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi;
      for (const std::size_t k : {0u, 1u, 2u}) {
        error.levels += std::abs(image(x, y)[k] - truth.image(x, y)[k]) / 3.0;
      }
      pressure += truth.pressure(x, y);
      if (answer.pressure.pixels().empty()) continue;
      error.pressure += std::abs(answer.pressure(x, y) - truth.pressure(x, y));
    }
  }
  error.surface = 100 * std::sqrt(error.surface / count);
  error.normals /= count;
  error.levels /= count;
  error.pressure *= 100 / pressure;
  return error;
}

template <class Membrane>
std::function<Answer()> frame(const Membrane& membrane, const Image<double>& depth) {
  return
      [membrane, &depth, work = membrane.make_workspace(width, height),
       gel = Image<double>(width, height, rest), surface = Image<double>(width, height)]() mutable {
        membrane.press_into(surface, {depth.view(), gel.view(), {0, 0, width, height}}, work);
        return Answer{surface, {}};
      };
}

// A Gaussian by boxes as a membrane.
std::function<Answer()> boxes(double sigma, const Image<double>& depth) {
  return [=, &depth] {
    Image<double> over(width, height);
    for (std::size_t i = 0; i < over.pixels().size(); ++i) {
      over.pixels()[i] = std::max(0.0, rest - depth.pixels()[i]);
    }
    Image<double> surface = gaussian_boxes(over, sigma);
    for (std::size_t i = 0; i < over.pixels().size(); ++i) {
      surface.pixels()[i] =
          rest - std::max(surface.pixels()[i], over.pixels()[i] > 0 ? over.pixels()[i] : -inf);
    }
    return Answer{std::move(surface), {}};
  };
}

template <class T>
std::function<Answer()> layer(const Gel& gel, double tolerance, const Image<double>& depth) {
  Image<T> seen(width, height);
  std::transform(depth.pixels().begin(), depth.pixels().end(), seen.pixels().begin(),
                 [](double z) { return static_cast<T>(z); });
  const ElasticLayer<T> made(eye.cast<T>(), static_cast<T>(rest), gel,
                             {.tolerance = tolerance, .sideways = false});
  return [=] {
    const auto contact = made.press(seen);
    if constexpr (std::is_same_v<T, double>) {
      return Answer{contact.depth, contact.pressure};
    } else {
      Answer answer{Image<double>(width, height), Image<double>(width, height)};
      std::copy(contact.depth.pixels().begin(), contact.depth.pixels().end(),
                answer.surface.pixels().begin());
      std::copy(contact.pressure.pixels().begin(), contact.pressure.pixels().end(),
                answer.pressure.pixels().begin());
      return answer;
    }
  };
}

// Catmull and Rom's cubic between the four values around a place.
double between(const std::array<double, 4>& v, double t) {
  return v[1] +
         t / 2 *
             (v[2] - v[0] +
              t * (2 * v[0] - 5 * v[1] + 4 * v[2] - v[3] + t * (3 * (v[1] - v[2]) + v[3] - v[0])));
}

// The layer on pixels `step` times as wide, interpolated; the object itself where all of those
// around touch, and no less sunk than it elsewhere.
std::function<Answer()> coarse_layer(const Gel& gel, Index step, const Image<double>& depth) {
  const double s = step;
  const Camera<double> coarse{
      eye.fx / s,   eye.fy / s,   (eye.cx + 0.5) / s - 0.5, (eye.cy + 0.5) / s - 0.5,
      width / step, height / step};
  const ElasticLayer<double> made(coarse, rest, gel, {.sideways = false});
  return [=, &depth] {
    Image<double> seen(width / step, height / step);
    for (Index y = 0; y < seen.height(); ++y) {
      for (Index x = 0; x < seen.width(); ++x) {
        double sum = 0;
        for (Index k = 0; k < step * step; ++k)
          sum += depth(step * x + k % step, step * y + k / step);
        seen(x, y) = sum / (s * s);
      }
    }
    const auto contact = made.press(seen);
    Answer answer{Image<double>(width, height), Image<double>(width, height)};
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double u = (x + 0.5) / s - 0.5, v = (y + 0.5) / s - 0.5;
        const auto left = static_cast<Index>(std::floor(u)),
                   top = static_cast<Index>(std::floor(v));
        std::array<double, 4> down{}, across{};
        bool touches = true;
        for (Index j = 0; j < 4; ++j) {
          for (Index i = 0; i < 4; ++i) {
            const Index cx = std::clamp(left + i - 1, Index{0}, seen.width() - 1);
            const Index cy = std::clamp(top + j - 1, Index{0}, seen.height() - 1);
            across[static_cast<std::size_t>(i)] = contact.indentation(cx, cy);
            const bool is_beside = i > 0 && i < 3 && j > 0 && j < 3;
            touches = touches && (!is_beside || contact.pressure(cx, cy) > 0);
          }
          down[static_cast<std::size_t>(j)] = between(across, u - left);
        }
        const double object = rest - depth(x, y);
        answer.surface(x, y) = rest - (touches ? object : std::max(object, between(down, v - top)));
        answer.pressure(x, y) = contact.pressure(x / step, y / step);
      }
    }
    return answer;
  };
}

// Springs as stiff as to bear what the layer bears with the object where it is, and with such
// tension that they bend over as many pixels as the gel's Gaussian.
std::function<Answer()> springs(const Gel& gel, double force, double sigma,
                                const Image<double>& depth) {
  double sunk = 0;
  for (const double z : depth.pixels()) sunk += std::max(0.0, rest - z);
  Gel bed{force * gel.thickness / (sunk * pitch * pitch), gel.poisson_ratio, gel.thickness};
  bed.tension = bed.stiffness() * sigma * sigma * pitch * pitch;
  if (sigma > 0) {
    // The tension bears, too: how much, where the object stays where it is, by secants.
    double more = force, last_more = 0, last_travel = 0;
    for (int i = 0; i < 12; ++i) {
      const double travel = SpringBed(eye, rest, bed).press(depth, more).displacement;
      if (std::abs(travel) < 1e-3 * press_depth * pitch) break;
      const double slope = i > 0 && more != last_more ? (travel - last_travel) / (more - last_more)
                                                      : press_depth * pitch / force;
      last_more = more;
      last_travel = travel;
      more = std::max(more / 4, more - travel / slope);
    }
    bed.elastic_modulus *= force / more;
    bed.tension *= force / more;
  }
  return [=, &depth, made = SpringBed(eye, rest, bed)] {
    const auto contact = made.press(depth, force);
    Answer answer{Image<double>(width, height, rest), Image<double>(width, height)};
    const auto down = [&](Index x, Index y) {
      return contact.indentation(std::clamp(x, Index{0}, width - 1),
                                 std::clamp(y, Index{0}, height - 1));
    };
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double here = down(x, y);
        answer.surface(x, y) -= here;
        if (contact.touching(x, y) == 0) continue;
        const double bent =
            4 * here - down(x - 1, y) - down(x + 1, y) - down(x, y - 1) - down(x, y + 1);
        answer.pressure(x, y) = bed.stiffness() * here + bed.tension * bent / (pitch * pitch);
      }
    }
    return answer;
  };
}

std::vector<Model> models(const Shape& shape, const Gel& gel, double force,
                          const Image<double>& depth) {
  const double sigma = gaussian_sigma(gel, shape.radius * pitch) / pitch;
  const std::vector<double> taxim{15, 7, 3};
  const auto bulging = [&](int kernels) {
    return frame(BulgingMembrane<double>(eye, rest, gel, {.kernels = kernels}), depth);
  };
  return {
      {"blur/Gaussian, sigma 5", frame(GaussianMembrane<double>(), depth)},
      {"blur/Gaussian of the gel",
       frame(GaussianMembrane<double>(sigma, static_cast<Index>(std::ceil(4 * sigma))), depth)},
      {"blur/three boxes", boxes(sigma, depth)},
      {"blur/pyramid", frame(PyramidMembrane<double>(taxim), depth)},
      {"blur/flat GelSight", frame(FlatGelSightMembrane<double>(), depth)},
      {"springs/alone", springs(gel, force, 0, depth)},
      {"springs/with tension", springs(gel, force, sigma, depth)},
      {"bulging/2 kernels", bulging(2)},
      {"bulging/4 kernels", bulging(4)},
      {"coarse layer/1:4", coarse_layer(gel, 4, depth)},
      {"coarse layer/1:2", coarse_layer(gel, 2, depth)},
      {"layer/to 10 %", layer<double>(gel, 0.1, depth)},
      {"layer/to 1 %", layer<double>(gel, 1e-2, depth)},
      {"layer/to 0.1 %", layer<double>(gel, 1e-3, depth)},
      {"layer/float", layer<float>(gel, 1e-3, depth)},
  };
}

// A row's sums over the shapes.
struct Row {
  std::string model;
  Error error;
  double ms = 0;
  bool has_pressure = false;
};

void add_shape(std::vector<Row>& rows, const Shape& shape, const Gel& gel, int rounds) {
  Image<double> depth(width, height, inf);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      depth(x, y) = rest - pitch * shape.overlap(x - 159.7, y - 119.2);
    }
  }
  const auto exact =
      ElasticLayer(eye, rest, gel, {.tolerance = 1e-4, .sideways = false}).press(depth);
  if (!exact.converged) std::abort();
  const Truth truth{exact.depth, exact.pressure, photograph(exact.depth),
                    std::min(115.0, 2.5 * shape.radius)};
  const auto here = models(shape, gel, -exact.force.z(), depth);
  rows.resize(here.size());
  std::vector<std::vector<double>> times(here.size());
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < here.size(); ++i) {
      const std::clock_t start = std::clock();
      const Answer answer = here[i].press();
      const double ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      if (round > 0) {
        times[i].push_back(ms);
        continue;
      }
      const Error error = compare(answer, truth);
      rows[i].model = here[i].name;
      rows[i].error.surface += error.surface;
      rows[i].error.normals += error.normals;
      rows[i].error.levels += error.levels;
      rows[i].error.pressure += error.pressure;
      rows[i].has_pressure = !answer.pressure.pixels().empty();
    }
  }
  for (std::size_t i = 0; i < here.size(); ++i) rows[i].ms += median(times[i]);
}

}  // namespace

int main(int count, char** arguments) try {
  if (count > 2 || (count == 2 && arguments[1][0] == '-')) {
    throw std::runtime_error("usage: membranes [COMMIT]");
  }
  constexpr int rounds = 3;
  const auto ball = [](double radius, double x0) {
    return [=](double x, double y) {
      return press_depth * (1 - ((x - x0) * (x - x0) + y * y) / (2 * radius * radius));
    };
  };
  const std::vector<Shape> shapes{
      {30, ball(30, 0)},
      {30,  // an edge with ends
       [](double x, double y) {
         const double u = 0.955 * x + 0.296 * y, v = 0.955 * y - 0.296 * x;
         return std::abs(v) < 50 ? press_depth * (1 - std::abs(u) / 30) : -inf;
       }},
      {30,  // a grating
       [=](double x, double y) { return ball(30, 0)(x, y) + 0.4 * std::cos(x / 2.5); }},
      {13, [=](double x, double y) { return std::max(ball(13, -20)(x, y), ball(13, 20)(x, y)); }}};
  std::printf(
      "{\"context\": {\"commit\": \"%s\", \"cpu\": \"%s\", \"compiler\": \"%s\", "
      "\"flags\": \"%s\"},\n\"benchmarks\": [",
      count > 1 ? arguments[1] : "unknown", bench::processor().c_str(), bench::compiler().c_str(),
      GELIGHT_FLAGS);
  const char* separator = "";
  const auto shape_count = static_cast<double>(shapes.size());
  for (const auto& [name, share] :
       {std::pair{"thin", 0.35}, std::pair{"medium", 1.0}, std::pair{"thick", 4.0}}) {
    for (const double nu : {0.3, 0.45, 0.49, 0.5}) {
      std::vector<Row> rows;
      for (const Shape& shape : shapes) {
        add_shape(rows, shape, {1e5, nu, share * shape.radius * pitch}, rounds);
      }
      for (const Row& row : rows) {
        std::printf(
            "%s\n{\"name\": \"membranes/%s/%.2f/%s\", \"ms\": %.3g, \"surface\": %.3g, "
            "\"normals\": %.3g, \"levels\": %.3g",
            separator, name, nu, row.model.c_str(), row.ms / shape_count,
            row.error.surface / shape_count, row.error.normals / shape_count,
            row.error.levels / shape_count);
        if (row.has_pressure) std::printf(", \"pressure\": %.3g", row.error.pressure / shape_count);
        std::printf("}");
        separator = ",";
      }
      std::fflush(stdout);
    }
  }
  std::printf("\n]}\n");
} catch (...) {
  return told();
}
