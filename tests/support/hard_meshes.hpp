#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/views/mesh_view.hpp"

// Meshes on which methods fail, with the answer known by construction.

namespace gelight::test {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline Index uniform_index(Random& random, Index count) {
  return std::uniform_int_distribution<Index>(0, count - 1)(random);
}

inline double longest_edge(const Surface<double>& surface) {
  double longest = 0;
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    longest = std::max(longest, surface.length(h));
  }
  return longest;
}

/// A flat sheet of n x n unit cells, each cut along a random diagonal.
inline Mesh<double> random_grid(Index n, Random& random) {
  Mesh<double> mesh = grid<double>(n, n, n, n);
  for (std::size_t f = 0; f < mesh.faces.size(); f += 2) {
    if (uniform(random, 0, 1) < 0.5) continue;
    const auto [a, b, d] = mesh.faces[f];
    const Index c = mesh.faces[f + 1][2];
    mesh.faces[f] = {a, b, c};
    mesh.faces[f + 1] = {b, d, c};
  }
  return mesh;
}

/// Splits a face in three by a new vertex, which lies from a point of its first edge, at a share of
/// it, on the way to the third corner, by another share.
inline void split_face(Mesh<double>& mesh, Index face, double along, double aside) {
  const auto f = static_cast<std::size_t>(face);
  const auto [a, b, c] = mesh.faces[f];
  const auto at = [&](Index v) -> const std::array<double, 3>& {
    return mesh.positions[static_cast<std::size_t>(v)];
  };
  std::array<double, 3> p{};
  for (std::size_t x = 0; x < 3; ++x) {
    p[x] = (1 - aside) * ((1 - along) * at(a)[x] + along * at(b)[x]) + aside * at(c)[x];
  }
  const auto v = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back(p);
  mesh.faces[f] = {a, b, v};
  mesh.faces.push_back({b, c, v});
  mesh.faces.push_back({c, a, v});
}

/// Moves the inner vertices of random_grid by up to `share` of a cell in both directions, at most a
/// quarter: beyond that faces may turn over, and no distance there is that of the plane. (The
/// corner across a diagonal comes nearer to it by share sqrt(2), the diagonal to that by as much,
/// and they were sqrt(1/2) apart.)
inline Mesh<double> jittered_grid(Index n, double share, Random& random) {
  if (share > 0.25) throw std::invalid_argument("a grid jittered by more than a quarter folds");
  Mesh<double> mesh = random_grid(n, random);
  for (auto& [x, y, z] : mesh.positions) {
    if (x == 0 || y == 0 || x == n || y == n) continue;
    x += uniform(random, -share, share);
    y += uniform(random, -share, share);
  }
  return mesh;
}

/// A cone of `spokes` plane sides round vertex 0, of total angle `angle` there: vertex
/// 1 + spokes k + j lies at distance radii[k] from the apex, in direction j angle / spokes of the
/// flattened cone. Angles beyond 2 pi make a saddle of alternating heights (an even number of
/// spokes).
inline Mesh<double> cone(double angle, Index spokes, std::span<const double> radii) {
  Mesh<double> mesh;
  mesh.positions.push_back({0, 0, 0});
  const double turn = 2 * std::numbers::pi / spokes, side = angle / spokes;
  // cos(side) = c^2 cos(turn) + s s', where the heights s, s' are equal or alternate.
  const bool saddle = angle > 2 * std::numbers::pi;
  const double c2 = saddle ? (1 + std::cos(side)) / (1 + std::cos(turn))
                           : (1 - std::cos(side)) / (1 - std::cos(turn));
  const double c = std::sqrt(c2), s = std::sqrt(1 - c2);
  for (const double r : radii) {
    for (Index j = 0; j < spokes; ++j) {
      const double up = saddle && j % 2 == 1 ? -s : s;
      mesh.positions.push_back({r * c * std::cos(j * turn), r * c * std::sin(j * turn), r * up});
    }
  }
  const auto ring = static_cast<Index>(radii.size());
  for (Index j = 0; j < spokes; ++j) {
    const Index k = (j + 1) % spokes;
    mesh.faces.push_back({0, 1 + j, 1 + k});
    for (Index r = 0; r + 1 < ring; ++r) {
      const Index a = 1 + spokes * r, b = a + spokes;
      mesh.faces.push_back({a + j, b + j, b + k});
      mesh.faces.push_back({a + j, b + k, a + k});
    }
  }
  return mesh;
}

/// The distance between two points of such a cone, in polar coordinates of the flattened cone.
inline double cone_distance(double angle, double r, double s, double theta) {
  theta = std::fabs(theta);
  theta = std::min(theta, angle - theta);
  if (theta >= std::numbers::pi) return r + s;
  // |r - s e^(i theta)|, without cancellation where both points are close.
  const double half = std::sin(theta / 2);
  return std::sqrt((r - s) * (r - s) + 4 * r * s * half * half);
}

/// A flat sheet [0, n]^2 with the faces taken away for which `hole(x, y)` holds at the centre.
template <class Hole>
Mesh<double> sheet_with_hole(Index n, Random& random, Hole hole) {
  Mesh<double> mesh = random_grid(n, random);
  std::erase_if(mesh.faces, [&](const auto& face) {
    double x = 0, y = 0;
    for (const Index v : face) {
      x += mesh.positions[static_cast<std::size_t>(v)][0] / 3;
      y += mesh.positions[static_cast<std::size_t>(v)][1] / 3;
    }
    return hole(x, y);
  });
  return mesh;
}

/// A flat sheet [0, n]^2 with a slit along x = n/2 from y = n/2 up: the vertices there are doubled.
inline Mesh<double> slit_sheet(Index n, Random& random) {
  Mesh<double> mesh = random_grid(n, random);
  std::map<Index, Index> twin;
  const auto count = static_cast<Index>(mesh.positions.size());
  for (Index v = 0; v < count; ++v) {
    const auto p = mesh.positions[static_cast<std::size_t>(v)];
    if (2 * p[0] != n || 2 * p[1] <= n) continue;
    twin[v] = static_cast<Index>(mesh.positions.size());
    mesh.positions.push_back(p);
  }
  for (auto& face : mesh.faces) {
    double x = 0;
    for (const Index v : face) x += mesh.positions[static_cast<std::size_t>(v)][0] / 3;
    if (2 * x < n) continue;
    for (Index& v : face) v = twin.contains(v) ? twin[v] : v;
  }
  return mesh;
}

/// Small meshes of every kind for comparison with brute force, chosen by `kind`, modulo 10.
inline Mesh<double> small_random_mesh(int kind, Random& random) {
  const auto displace = [&](Mesh<double>& mesh, double size) {
    for (auto& p : mesh.positions) {
      for (double& x : p) x += uniform(random, -size, size);
    }
  };
  const auto stretch = [&](Mesh<double>& mesh, double factor) {
    const auto axis = static_cast<std::size_t>(uniform_index(random, 3));
    for (auto& p : mesh.positions) p[axis] *= factor;
  };
  const auto remove_faces = [&](Mesh<double>& mesh, double share) {
    std::erase_if(mesh.faces, [&](const auto&) { return uniform(random, 0, 1) < share; });
    if (mesh.faces.empty()) mesh.faces.push_back({0, 1, 2});
  };
  const auto flip_faces = [&](Mesh<double>& mesh) {
    for (auto& face : mesh.faces) {
      if (uniform(random, 0, 1) < 0.5) std::swap(face[0], face[1]);
    }
  };
  const auto add_fins = [&](Mesh<double>& mesh, int count) {
    for (int i = 0; i < count; ++i) {
      const auto face = mesh.faces[static_cast<std::size_t>(
          uniform_index(random, static_cast<Index>(mesh.faces.size())))];
      const auto k = static_cast<std::size_t>(uniform_index(random, 3));
      const Index a = face[k], b = face[(k + 1) % 3];
      const auto p = mesh.positions[static_cast<std::size_t>(a)];
      const auto q = mesh.positions[static_cast<std::size_t>(b)];
      std::array<double, 3> r{};
      for (std::size_t c = 0; c < 3; ++c) r[c] = (p[c] + q[c]) / 2 + uniform(random, -0.7, 0.7);
      mesh.faces.push_back({a, b, static_cast<Index>(mesh.positions.size())});
      mesh.positions.push_back(r);
    }
  };
  Mesh<double> mesh;
  switch (kind % 10) {
    case 0:  // convex
      mesh = icosphere<double>(0);
      displace(mesh, 0.05);
      stretch(mesh, uniform(random, 0.3, 3));
      break;
    case 1:  // closed, not convex
      mesh = icosphere<double>(0);
      displace(mesh, 0.5);
      break;
    case 2:  // rough sheet
      mesh = random_grid(4, random);
      displace(mesh, 0.4);
      break;
    case 3:  // sheet with holes, bow-ties and loose pieces
      mesh = random_grid(4, random);
      displace(mesh, 0.3);
      remove_faces(mesh, 0.3);
      break;
    case 4:  // slivers
      mesh = random_grid(4, random);
      displace(mesh, 0.4);
      stretch(mesh, uniform(random, 30, 1000));
      break;
    case 5:  // flat, with many ties and flat vertices
      mesh = random_grid(3 + uniform_index(random, 3), random);
      break;
    case 6:  // fins on a closed surface
      mesh = icosphere<double>(0);
      displace(mesh, 0.4);
      add_fins(mesh, 3);
      flip_faces(mesh);
      break;
    case 7:  // fins on a sheet with holes
      mesh = random_grid(3, random);
      displace(mesh, 0.3);
      remove_faces(mesh, 0.2);
      add_fins(mesh, 4);
      break;
    case 8:  // a torus, pressed
      mesh = torus<double>(2, 0.7, 5, 4);
      displace(mesh, 0.3);
      stretch(mesh, uniform(random, 0.2, 2));
      break;
    default:  // a box of 2 x 1 x 1 cells: right angles, ties
      mesh = torus<double>(1, 0.5, 4, 4);
      flip_faces(mesh);
      break;
  }
  return mesh;
}

/// A random point of a mesh: a vertex, on an edge or inside a face.
inline SurfacePoint<double> random_point(const Mesh<double>& mesh, Random& random) {
  const Index f = uniform_index(random, static_cast<Index>(mesh.faces.size()));
  const auto face = mesh.faces[static_cast<std::size_t>(f)];
  switch (uniform_index(random, 3)) {
    case 0:
      return vertex_point<double>(face[0]);
    case 1:
      return edge_point<double>(face[0], face[1], uniform(random, 0, 1));
    default: {
      const double a = uniform(random, 0, 1), b = uniform(random, 0, 1 - a);
      return face_point<double>(f, {a, b, 1 - a - b});
    }
  }
}

}  // namespace gelight::test
