#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {
namespace detail {

[[nodiscard]] bool is_size(std::floating_point auto x) { return x > 0 && std::isfinite(x); }

}  // namespace detail

template <std::floating_point T>
Mesh<T> grid(Index columns, Index rows, T width, T height) {
  detail::require(columns > 0 && rows > 0, "grid of ", columns, " x ", rows, " cells");
  detail::require(detail::is_size(width) && detail::is_size(height), "grid of size ", width, " x ",
                  height);
  detail::require((columns + 1.0) * (rows + 1.0) < std::numeric_limits<Index>::max(), "grid of ",
                  columns, " x ", rows, " cells, which has more vertices than can be counted");
  const auto at = [](T size, Index i, Index count) {
    const T several = size * static_cast<T>(i);
    // Beyond the numbers of T, though a share of the size is not.
    if (!(several <= std::numeric_limits<T>::max())) {
      return i == count ? size : size / static_cast<T>(count) * static_cast<T>(i);
    }
    return several / static_cast<T>(count);
  };
  Mesh<T> mesh;
  for (Index y = 0; y <= rows; ++y) {
    for (Index x = 0; x <= columns; ++x) {
      mesh.positions.push_back({at(width, x, columns), at(height, y, rows), 0});
    }
  }
  for (Index y = 0; y < rows; ++y) {
    for (Index x = 0; x < columns; ++x) {
      const Index a = y * (columns + 1) + x;
      const Index b = a + columns + 1;
      mesh.faces.push_back({a, a + 1, b + 1});
      mesh.faces.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

template <std::floating_point T>
Mesh<T> icosphere(int level, T radius) {
  using namespace detail::arithmetic;
  detail::require(level >= 0 && level <= 12, "icosphere of level ", level);
  detail::require(detail::is_size(radius), "icosphere of radius ", radius);
  using Real = std::common_type_t<T, double>;
  const double phi = std::numbers::phi;
  detail::Array<Vec3<Real>> points{{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                                   {0, -1, phi}, {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                                   {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
  decltype(Mesh<T>::faces) faces{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (auto& p : points) p = normalized(p);

  struct Middle {
    Index end = -1, vertex = -1;
  };
  for (int i = 0; i < level; ++i) {
    // Of the edges at each vertex, six at most, those to higher ones.
    detail::Array<Middle> middles(6 * points.size());
    const auto middle = [&](Index a, Index b) {
      const Index high = std::max(a, b);
      auto at = 6 * std::ptrdiff_t{std::min(a, b)};
      while (middles[at].end >= 0 && middles[at].end != high) ++at;
      if (middles[at].end < 0) {
        middles[at] = {high, static_cast<Index>(points.size())};
        points.push_back(normalized(points[a] + points[b]));
      }
      return middles[at].vertex;
    };
    decltype(Mesh<T>::faces) finer;
    finer.reserve(4 * faces.size());
    for (const auto& [a, b, c] : faces) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const auto& face : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) {
        finer.push_back(face);
      }
    }
    faces = std::move(finer);
  }

  Mesh<T> mesh;
  mesh.faces = std::move(faces);
  for (const auto& p : points) {
    mesh.positions.push_back({static_cast<T>(radius * p[0]), static_cast<T>(radius * p[1]),
                              static_cast<T>(radius * p[2])});
  }
  return mesh;
}

template <std::floating_point T>
Mesh<T> box(T x, T y, T z) {
  detail::require(detail::is_size(x) && detail::is_size(y) && detail::is_size(z), "box of size ", x,
                  " x ", y, " x ", z);
  Mesh<T> mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({(i & 1 ? x : -x) / 2, (i & 2 ? y : -y) / 2, (i & 4 ? z : -z) / 2});
  }
  mesh.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

template <std::floating_point T>
Mesh<T> revolve(std::span<const ProfilePoint<T>> profile, T edge_length) {
  detail::require(profile.size() >= 2, "outline of ", profile.size(), " points");
  detail::require(detail::is_size(edge_length), "edge length ", edge_length);
  struct Ring {
    Index first = 0, count = 0;
    double turn = 0;  // angle of the first vertex, as a share of the whole turn
  };
  // Counted before any is made: too many would fill the memory first.
  const auto around = [&](T radius) {
    return std::max(3.0, std::round(2 * std::numbers::pi * double{radius} / double{edge_length}));
  };
  double vertices = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const T radius = profile[i].radius;
    detail::require(radius >= 0 && std::isfinite(radius), "point ", i,
                    " of the outline has radius ", radius);
    detail::require(std::isfinite(profile[i].z), "point ", i, " of the outline has height ",
                    profile[i].z);
    vertices += radius > 0 ? around(radius) : 1;
    detail::require(around(radius) < 1e8, "ring of ", around(radius), " vertices");
    detail::require(vertices < std::numeric_limits<Index>::max(),
                    "an outline that makes more vertices than can be counted");
  }
  Mesh<T> mesh;
  Ring below;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const auto [radius, z] = profile[i];
    Ring ring{static_cast<Index>(mesh.positions.size()), 1, 0};
    if (radius > 0) {
      ring.count = static_cast<Index>(around(radius));
      // Where the count stays, each ring stands in the gaps of the one below.
      const double step = 1.0 / ring.count;
      ring.turn = std::fmod(below.turn + step / 2, step);
    }
    for (Index k = 0; k < ring.count; ++k) {
      const double angle = 2 * std::numbers::pi * (ring.turn + static_cast<double>(k) / ring.count);
      mesh.positions.push_back(
          {static_cast<T>(radius * std::cos(angle)), static_cast<T>(radius * std::sin(angle)), z});
    }
    if (i > 0) {
      detail::require(below.count > 1 || ring.count > 1, "points ", i - 1, " and ", i,
                      " of the outline are both on the axis");
      // Zip the two rings: always advance the one whose next vertex comes first.
      const auto at = [](const Ring& r, Index k) { return r.first + k % r.count; };
      const auto turn = [](const Ring& r, Index k) {
        return r.turn + static_cast<double>(k) / r.count;
      };
      const Index low_steps = below.count > 1 ? below.count : 0;
      const Index high_steps = ring.count > 1 ? ring.count : 0;
      for (Index low = 0, high = 0; low < low_steps || high < high_steps;) {
        const bool advance_low =
            high == high_steps || (low < low_steps && turn(below, low + 1) < turn(ring, high + 1));
        const Index third = advance_low ? at(below, low + 1) : at(ring, high + 1);
        mesh.faces.push_back({at(below, low), third, at(ring, high)});
        ++(advance_low ? low : high);
      }
    }
    below = ring;
  }
  return mesh;
}

template <std::floating_point T>
Mesh<T> membrane(T radius, T length, T edge_length) {
  detail::require(edge_length > 0 && edge_length <= radius, "membrane with edge length ",
                  edge_length, " and radius ", radius);
  detail::require(radius <= length && std::isfinite(length), "membrane with radius ", radius,
                  " and length ", length);
  // Of its area, 2 pi radius length, each vertex has that of two equilateral triangles.
  detail::require(2 * std::numbers::pi / std::sqrt(0.75) * (double{radius} / double{edge_length}) *
                          (double{length} / double{edge_length}) <
                      std::numeric_limits<Index>::max(),
                  "membrane with edge length ", edge_length, ", radius ", radius, " and length ",
                  length, ", which makes more vertices than can be counted");
  const T wall = length - radius;
  // Rings of equilateral triangles are sqrt(3)/2 edges apart.
  const auto rings = [&](T distance) {
    return static_cast<int>(std::ceil(distance / (edge_length * std::sqrt(T(0.75)))));
  };
  const T quarter = std::numbers::pi_v<T> / 2;
  detail::require(std::isfinite(radius * quarter), "membrane with radius ", radius,
                  ", about whose end it is farther than numbers go");
  const int wall_rings = rings(wall), cap_rings = rings(radius * quarter);
  std::vector<ProfilePoint<T>> profile;
  profile.reserve(static_cast<std::size_t>(wall_rings + cap_rings) + 1);
  for (int i = 0; i < wall_rings; ++i) {
    profile.push_back({radius, wall * static_cast<T>(i) / static_cast<T>(wall_rings)});
  }
  for (int i = 0; i < cap_rings; ++i) {
    const T angle = quarter * static_cast<T>(i) / static_cast<T>(cap_rings);
    profile.push_back({radius * std::cos(angle), wall + radius * std::sin(angle)});
  }
  profile.push_back({0, length});
  return revolve<T>(profile, edge_length);
}

template <std::floating_point T>
Mesh<T> torus(T major_radius, T minor_radius, Index around, Index across) {
  detail::require(
      minor_radius > 0 && minor_radius < major_radius && std::isfinite(major_radius + minor_radius),
      "torus with radii ", major_radius, " and ", minor_radius);
  detail::require(around >= 3 && across >= 3 &&
                      static_cast<double>(around) * across < std::numeric_limits<Index>::max(),
                  "torus of ", around, " x ", across, " vertices");
  Mesh<T> mesh;
  for (Index i = 0; i < around; ++i) {
    for (Index j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double v = 2 * std::numbers::pi * j / across;
      const double r = major_radius + minor_radius * std::cos(v);
      mesh.positions.push_back({static_cast<T>(r * std::cos(u)), static_cast<T>(r * std::sin(u)),
                                static_cast<T>(minor_radius * std::sin(v))});
      const Index next_i = (i + 1) % around, next_j = (j + 1) % across;
      const Index a = i * across + j, b = next_i * across + j;
      const Index c = next_i * across + next_j, d = i * across + next_j;
      mesh.faces.push_back({a, b, c});
      mesh.faces.push_back({a, c, d});
    }
  }
  return mesh;
}

template <std::floating_point T>
Mesh<T> placed(Mesh<T> mesh, const std::type_identity_t<Eigen::Matrix<T, 3, 3>>& rotation,
               const std::type_identity_t<Vec3<T>>& translation) {
  using namespace detail::arithmetic;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      detail::require(std::isfinite(rotation(i, j)), "the rotation (", i, ", ", j, ") is ",
                      rotation(i, j), ", not finite");
    }
    detail::require(std::isfinite(translation[i]), "the translation (", i, ") is ", translation[i],
                    ", not finite");
  }
  for (auto& [x, y, z] : mesh.positions) {
    const Vec3<T> p = rotation * Vec3<T>(x, y, z) + translation;
    x = p[0], y = p[1], z = p[2];
  }
  return mesh;
}

template <std::floating_point T>
Mesh<T> joined(std::span<const Mesh<T>> parts) {
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Mesh<T>& part = parts[i];
    const std::size_t own = part.positions.size();
    for (std::size_t f = 0; f < part.faces.size(); ++f) {
      for (const Index v : part.faces[f]) {
        detail::require(v >= 0 && std::cmp_less(v, own), "face ", f, " of part ", i, " has vertex ",
                        v, ", the part has ", own, " vertices");
      }
    }
    vertices += own;
    detail::require(std::cmp_less_equal(vertices, std::numeric_limits<Index>::max()),
                    "parts of more vertices than can be counted");
  }
  Mesh<T> whole;
  for (const Mesh<T>& part : parts) {
    const auto first = static_cast<Index>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
    for (const auto& [a, b, c] : part.faces) {
      whole.faces.push_back({first + a, first + b, first + c});
    }
  }
  return whole;
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template Mesh<float> grid<float>(Index, Index, float, float);
template Mesh<float> icosphere<float>(int, float);
template Mesh<float> box<float>(float, float, float);
template Mesh<float> revolve<float>(std::span<const ProfilePoint<float>>, float);
template Mesh<float> torus<float>(float, float, Index, Index);
template Mesh<float> placed<float>(Mesh<float>, const Eigen::Matrix<float, 3, 3>&,
                                   const Vec3<float>&);
template Mesh<float> joined<float>(std::span<const Mesh<float>>);
template Mesh<float> membrane<float>(float, float, float);
template Mesh<double> grid<double>(Index, Index, double, double);
template Mesh<double> icosphere<double>(int, double);
template Mesh<double> box<double>(double, double, double);
template Mesh<double> revolve<double>(std::span<const ProfilePoint<double>>, double);
template Mesh<double> torus<double>(double, double, Index, Index);
template Mesh<double> placed<double>(Mesh<double>, const Eigen::Matrix<double, 3, 3>&,
                                     const Vec3<double>&);
template Mesh<double> joined<double>(std::span<const Mesh<double>>);
template Mesh<double> membrane<double>(double, double, double);
}  // namespace gelight
#endif
