#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <variant>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

// Reflectances that were fitted to photographs (sensor/calibrate.hpp): by how much a pixel becomes
// brighter or darker than its background when the gel there tilts. Each gives a share of the
// background, a channel: a pixel shows background * (1 + change).
namespace gelight {

/// What a pixel sees of the gel.
struct GelPoint {
  double nx = 0;         ///< the unit normal's coordinate along rows; it faces the camera
  double ny = 0;         ///< and along columns
  double x = 0;          ///< place in the image, -1 at its first column and 1 at its last
  double y = 0;          ///< and of its rows
  bool touched = false;  ///< pressed by an object here, rather than free
};

/// By how much of its background a pixel becomes brighter: red, green, blue.
using Change = std::array<double, 3>;

namespace detail {

/// The quadratic terms in the place by which reflectances vary over the image.
inline constexpr int place_terms = 6;
[[nodiscard]] inline std::array<double, place_terms> terms_of_place(double x, double y) {
  return {1, x, y, x * x, x * y, y * y};
}

}  // namespace detail

/// A smooth table over the normal's two coordinates, bilinear between nodes, each node of which is
/// quadratic in the place. One for gel that is touched, one for free gel, whose middle is 0.
struct TableReflectance {
  int nodes = 9;     ///< along each coordinate, odd
  double reach = 1;  ///< the largest coordinate; beyond, it counts as this
  /// For each node (row by row), each of the place's terms 1, x, y, x^2, xy, y^2 and each channel.
  std::vector<double> touched;  ///< numbers of gel that something touches
  std::vector<double> free;     ///< and of gel that nothing touches

  /// How many nodes times terms of the place there are: a third of the numbers of either table.
  [[nodiscard]] int size() const { return nodes * nodes * detail::place_terms; }

  /// Calls use(node, share) for the four nodes around a normal.
  template <class Use>
  void for_factors(const GelPoint& p, const Use& use) const {
    const double last = nodes - 1;
    const double u = std::clamp((p.nx / reach + 1) / 2 * last, 0.0, last);
    const double v = std::clamp((p.ny / reach + 1) / 2 * last, 0.0, last);
    const int i = std::min(static_cast<int>(u), nodes - 2);
    const int j = std::min(static_cast<int>(v), nodes - 2);
    const double f = u - i, g = v - j;
    const int node = j * nodes + i;
    use(node, (1 - f) * (1 - g));
    use(node + 1, f * (1 - g));
    use(node + nodes, (1 - f) * g);
    use(node + nodes + 1, f * g);
  }
};

/// A polynomial of the normal's coordinates, times one of second degree in the place: what Taxim
/// fits, there in bins of the normal. (Si, Yuan, Taxim: An Example-based Simulation Model for
/// GelSight Tactile Sensors, 2022, doi:10.1109/LRA.2022.3142412)
struct PolynomialReflectance {
  int degree = 3;    ///< in the normal
  double reach = 1;  ///< the largest coordinate; beyond, it counts as this
  /// For each power of the normal (1, nx, ny, nx^2, ...), term of the place and channel.
  std::vector<double> touched;  ///< numbers of gel that something touches
  std::vector<double> free;     ///< and of gel that nothing touches

  /// How many numbers there are.
  [[nodiscard]] int size() const { return (degree + 1) * (degree + 2) / 2 * detail::place_terms; }

  /// Calls use(power, monomial) for each power of the normal.
  template <class Use>
  void for_factors(const GelPoint& p, const Use& use) const {
    const double u = std::clamp(p.nx / reach, -1.0, 1.0), v = std::clamp(p.ny / reach, -1.0, 1.0);
    int power = 0;
    for (int total = 0; total <= degree; ++total) {
      for (int of_v = 0; of_v <= total; ++of_v, ++power) {
        double monomial = 1;
        for (int k = 0; k < total; ++k) monomial *= k < of_v ? v : u;
        use(power, monomial);
      }
    }
  }
};

/// A light near the gel.
struct NearLight {
  /// Half images to the right of and below the image's middle, and towards the camera from the gel
  /// (all in units of half the image's width).
  Vec3<double> place{0, 0, 1};
  /// Colour of what is reflected diffusely, and in mirrors.
  Change diffuse{}, specular{};  ///< shares of the background at a distance of 1
};

/// A few near lights, the physical model: soft-clamped Lambert and a Phong highlight, both falling
/// off with the distance, ambient light that grows with the slope, and a constant for touched gel.
struct LightsReflectance {
  /// Near the gel.
  std::vector<NearLight> lights;
  double softness = 0.3;       ///< over how much of the cosine a light fades at grazing incidence
  double falloff = 1;          ///< the power of the distance by which light falls off
  double shininess = 8;        ///< Phong's exponent
  Change ambient{};            ///< times 1 - nz
  Change contact{};            ///< of touched gel, whatever its normal
  Change free_share{1, 1, 1};  ///< free gel changes by so much of what touched gel does
  double height = 1;           ///< of the image, in units of its width
};

/// Any of the fitted reflectances.
using FittedReflectance = std::variant<LightsReflectance, PolynomialReflectance, TableReflectance>;

namespace detail {

/// max(0, x), rounded off over `softness`.
[[nodiscard]] inline double soft_positive(double x, double softness) {
  const double t = x / softness;
  return t > 30 ? x : softness * std::log1p(std::exp(t));
}

/// What a light of that strength, that comes from the direction l, gives at a point with normal n,
/// diffuse and specular, that it does not give at rest.
struct LightTerms {
  double diffuse = 0, specular = 0;
};
[[nodiscard]] inline LightTerms terms_of(const LightsReflectance& model, double strength,
                                         const Vec3<double>& l, const Vec3<double>& n,
                                         const Vec3<double>& rest, const Vec3<double>& to_eye) {
  const auto shine = [&](const Vec3<double>& normal) {
    const double mirrored =
        2 * std::max(0.0, dot(normal, l)) * dot(normal, to_eye) - dot(l, to_eye);
    return std::pow(std::max(0.0, mirrored), model.shininess);
  };
  const double lit = soft_positive(dot(n, l), model.softness);
  return {strength * (lit - soft_positive(dot(rest, l), model.softness)),
          strength * (shine(n) - shine(rest))};
}
/// The same of a light at a place near flat gel that is seen from above.
[[nodiscard]] inline LightTerms light_terms(const LightsReflectance& model,
                                            const Vec3<double>& light, const Vec3<double>& n,
                                            double x, double y) {
  const Vec3<double> way(light.x() - x, light.y() - y * model.height, light.z());
  const double distance = norm(way);
  const Vec3<double> up(0, 0, 1);
  return terms_of(model, std::pow(distance, -model.falloff), way / distance, n, up, up);
}

// The change by a model whose coefficients are, for each factor of the normal, those of the place.
template <class Model>
[[nodiscard]] Change linear_change(const Model& model, const GelPoint& p) {
  constexpr std::size_t numbers = 3 * place_terms;
  const double* const coefficients = (p.touched ? model.touched : model.free).data();
  std::array<double, numbers> mixed{};
  model.for_factors(p, [&](int factor, double share) {
    const double* const own = coefficients + std::ptrdiff_t{numbers} * factor;
    for (std::size_t k = 0; k < numbers; ++k) mixed[k] += share * own[k];
  });
  const auto place = terms_of_place(p.x, p.y);
  Change sum{};
  for (std::size_t k = 0; k < numbers; ++k) sum[k % 3] += place[k / 3] * mixed[k];
  return sum;
}

}  // namespace detail

/// @name The change of a pixel by a reflectance, which has to have as many numbers as its `size`
/// says: not checked.
///@{
/// How much a point's colour differs from the background's, by a table.
[[nodiscard]] inline Change change(const TableReflectance& table, const GelPoint& p) {
  return detail::linear_change(table, p);
}
/// The same, by a polynomial.
[[nodiscard]] inline Change change(const PolynomialReflectance& polynomial, const GelPoint& p) {
  return detail::linear_change(polynomial, p);
}
/// The same, by near lights.
[[nodiscard]] inline Change change(const LightsReflectance& model, const GelPoint& p) {
  const double nz = std::sqrt(std::max(0.0, 1 - p.nx * p.nx - p.ny * p.ny));
  Change sum{};
  for (std::size_t c = 0; c < 3; ++c) sum[c] = model.ambient[c] * (1 - nz);
  for (const NearLight& light : model.lights) {
    const auto terms = detail::light_terms(model, light.place, {p.nx, p.ny, nz}, p.x, p.y);
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += light.diffuse[c] * terms.diffuse + light.specular[c] * terms.specular;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    sum[c] = p.touched ? sum[c] + model.contact[c] : sum[c] * model.free_share[c];
  }
  return sum;
}
/// The same, by whichever it is.
[[nodiscard]] inline Change change(const FittedReflectance& model, const GelPoint& p) {
  return std::visit([&](const auto& one) { return change(one, p); }, model);
}
///@}

namespace detail {

// Least squares on a grid of 5 x 5 places; for each of their terms the three channels. Moments of
// the grid make 1, x, y, x^2 - 1/2, xy and y^2 - 1/2 orthogonal, of squares 1, 1/2, 1/2, 7/40, 1/4
// and 7/40 in the mean.
template <class ChangeAt>
[[nodiscard]] std::array<double, 3 * std::size_t{place_terms}> nearest_quadratic(
    const ChangeAt& change_at) {
  std::array<Change, place_terms> mean{};
  for (int k = 0; k < 25; ++k) {
    const double x = 0.5 * (k % 5) - 1, y = 0.5 * (k / 5) - 1;
    const Change value = change_at(x, y);
    const std::array<double, place_terms> dual{
        1, x / 0.5, y / 0.5, (x * x - 0.5) / 0.175, x * y / 0.25, (y * y - 0.5) / 0.175};
    for (std::size_t t = 0; t < place_terms; ++t) {
      for (std::size_t c = 0; c < 3; ++c) mean[t][c] += dual[t] * value[c] / 25;
    }
  }
  std::array<double, 3 * std::size_t{place_terms}> terms{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t t = 0; t < place_terms; ++t) terms[3 * t + c] = mean[t][c];
    terms[c] -= 0.5 * (mean[3][c] + mean[5][c]);
  }
  return terms;
}

}  // namespace detail

namespace detail {

inline void require_finite(const std::vector<double>& numbers, const char* what) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    require(std::isfinite(numbers[i]), "number ", i, " of ", what, " is ", numbers[i]);
  }
}

/// Throws InvalidInput for a reflectance that cannot be, or has other than the numbers it needs.
///@{
inline void require_numbers(const char* kind, std::size_t wanted, double reach,
                            const std::vector<double>& touched, const std::vector<double>& free) {
  require(reach > 0 && reach <= 1, "a ", kind, " of reach ", reach, ", not in (0, 1]");
  require(touched.size() == wanted && free.size() == wanted, "a ", kind, " has ", touched.size(),
          " numbers for touched gel and ", free.size(), " for free, not ", wanted, " each");
  require_finite(touched, kind);
  require_finite(free, kind);
}
inline void require_reflectance(const TableReflectance& m) {
  require(m.nodes >= 3 && m.nodes <= 65, "a table of ", m.nodes, " nodes, not from 3 to 65");
  require_numbers("table", 3 * static_cast<std::size_t>(m.size()), m.reach, m.touched, m.free);
}
inline void require_reflectance(const PolynomialReflectance& m) {
  require(m.degree >= 1 && m.degree <= 65, "a polynomial of degree ", m.degree,
          ", not from 1 to 65");
  require_numbers("polynomial", 3 * static_cast<std::size_t>(m.size()), m.reach, m.touched, m.free);
}
inline void require_reflectance(const LightsReflectance& m) {
  require(m.softness > 0 && m.shininess > 0 && m.height > 0, "lights have softness ", m.softness,
          ", shininess ", m.shininess, " and height ", m.height, ", which are not all positive");
  require(m.lights.size() <= 65, m.lights.size(), " lights are more than 65");
  std::vector<double> numbers{m.softness, m.falloff, m.shininess, m.height};
  const auto add = [&](const Change& three) {
    numbers.insert(numbers.end(), three.begin(), three.end());
  };
  for (const Change& three : {m.ambient, m.contact, m.free_share}) add(three);
  for (const NearLight& light : m.lights) {
    add({light.place.x(), light.place.y(), light.place.z()});
    add(light.diffuse);
    add(light.specular);
  }
  require_finite(numbers, "lights");
}
inline void require_reflectance(const FittedReflectance& model) {
  std::visit([](const auto& one) { require_reflectance(one); }, model);
}
///@}

}  // namespace detail

/// A table of another reflectance, at `nodes` (odd) along each coordinate of the normal: between
/// nodes bilinear, in the place the quadratic nearest to it on a grid of 5 x 5. A table stays as it
/// is. Throws InvalidInput for a reflectance with numbers that cannot be or another count of them,
/// for one that is infinite or none at some normal and place, as by a light in the gel's surface,
/// and for nodes that are even or not from 3 to 65.
[[nodiscard]] inline TableReflectance tabulated(const FittedReflectance& model, int nodes = 17) {
  detail::require_reflectance(model);
  if (const auto* const table = std::get_if<TableReflectance>(&model)) return *table;
  detail::require(nodes >= 3 && nodes % 2 == 1 && nodes <= 65, "a table of ", nodes,
                  " nodes: an odd number from 3 to 65 is wanted");
  TableReflectance table;
  table.nodes = nodes;
  if (const auto* const p = std::get_if<PolynomialReflectance>(&model)) table.reach = p->reach;
  for (const bool touched : {true, false}) {
    std::vector<double>& numbers = touched ? table.touched : table.free;
    for (int node = 0; node < nodes * nodes; ++node) {
      // Corners of the table have no normal: the steepest in their direction.
      Vec2<double> n(node % nodes, node / nodes);
      n = table.reach * (2.0 / (nodes - 1) * n - Vec2<double>(1, 1));
      if (norm(n) > 0.999) n *= 0.999 / norm(n);
      const auto quadratic = detail::nearest_quadratic([&](double x, double y) {
        return change(model, {n.x(), n.y(), x, y, touched});
      });
      numbers.insert(numbers.end(), quadratic.begin(), quadratic.end());
    }
    detail::require_finite(numbers, touched ? "a reflectance's table of touched gel"
                                            : "a reflectance's table of free gel");
  }
  return table;
}

}  // namespace gelight
