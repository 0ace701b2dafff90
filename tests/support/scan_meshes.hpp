#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "support/hard_meshes.hpp"

// Closed, bordered, creased and noisy surfaces with bad triangles, as scanners and decimation make
// them. No distance on them has a closed form: the exact solver is the truth.

namespace gelight::test {

struct NamedMesh {
  std::string name;
  Mesh<double> mesh;
};

namespace scans {

inline double length_of(const Mesh<double>& mesh, Index a, Index b) {
  const auto &p = mesh.position(a), &q = mesh.position(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

inline double mean_edge(const Mesh<double>& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.faces) {
    sum += length_of(mesh, a, b) + length_of(mesh, b, c) + length_of(mesh, c, a);
  }
  return sum / (3 * static_cast<double>(mesh.faces.size()));
}

/// A ball with bumps: a smooth shape that is no sphere.
inline Mesh<double> blob(int level) {
  Mesh<double> mesh = icosphere<double>(level);
  for (auto& p : mesh.positions) {
    const auto [x, y, z] = p;
    const double r = 1 + 0.2 * std::sin(3 * x + 1) * std::cos(2 * y) + 0.15 * std::sin(5 * z + y);
    p = {r * x, r * y, r * z};
  }
  return mesh;
}

/// A ball pulled out into a box: twelve creases that the edges do not follow.
inline Mesh<double> creased(int level) {
  Mesh<double> mesh = icosphere<double>(level);
  for (auto& [x, y, z] : mesh.positions) {
    const double most = std::max({std::fabs(x), std::fabs(y), std::fabs(z)});
    x /= most, y /= most, z /= most;
  }
  return mesh;
}

/// A hilly sheet with a border, each cell cut along a random diagonal.
inline Mesh<double> terrain(Index n, Random& random) {
  Mesh<double> mesh = jittered_grid(n, 0.2, random);
  const double size = n;
  for (auto& [x, y, z] : mesh.positions) {
    z = size * (0.08 * std::sin(7 * x / size) * std::cos(5 * y / size) +
                0.03 * std::sin(19 * x / size + 11 * y / size));
  }
  return mesh;
}

/// Moves every vertex by up to `share` of the mean edge, any way.
inline Mesh<double> noisy(Mesh<double> mesh, double share, Random& random) {
  const double most = share * mean_edge(mesh);
  for (auto& p : mesh.positions) {
    for (double& x : p) x += uniform(random, -most, most);
  }
  return mesh;
}

inline Mesh<double> stretched(Mesh<double> mesh, double factor) {
  for (auto& p : mesh.positions) p[0] *= factor;
  return mesh;
}

/// Puts a vertex on every `every`-th edge, close to one of its ends: thin triangles, and corners
/// with an angle near pi.
inline Mesh<double> with_slivers(Mesh<double> mesh, std::size_t every, Random& random) {
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> faces_at;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      faces_at[{std::min(a, b), std::max(a, b)}].push_back(f);
    }
  }
  std::vector<char> is_split(mesh.faces.size(), 0);
  std::size_t count = 0;
  for (const auto& [edge, faces] : faces_at) {
    const bool is_free =
        std::none_of(faces.begin(), faces.end(), [&](std::size_t f) { return is_split[f] != 0; });
    if (++count % every != 0 || !is_free) continue;
    const auto [a, b] = edge;
    const double t = uniform(random, 0.02, 0.1);
    const auto p = mesh.position(a), q = mesh.position(b);
    const auto middle = static_cast<Index>(mesh.positions.size());
    mesh.positions.push_back(
        {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])});
    for (const std::size_t f : faces) {
      auto other = mesh.faces[f];
      std::replace(mesh.faces[f].begin(), mesh.faces[f].end(), b, middle);
      std::replace(other.begin(), other.end(), a, middle);
      mesh.faces.push_back(other);
      is_split[f] = 1;
    }
  }
  return mesh;
}

/// Without the faces that have a corner in one of some balls round vertices: borders and holes.
/// Vertices that are left in no face go, too.
inline Mesh<double> with_holes(const Mesh<double>& mesh, int holes, double radius, Random& random) {
  std::vector<char> is_out(mesh.positions.size(), 0);
  for (int i = 0; i < holes; ++i) {
    const Index centre = uniform_index(random, static_cast<Index>(mesh.positions.size()));
    for (std::size_t v = 0; v < is_out.size(); ++v) {
      is_out[v] |= length_of(mesh, centre, static_cast<Index>(v)) < radius;
    }
  }
  Mesh<double> rest;
  std::vector<Index> number(mesh.positions.size(), -1);
  for (auto face : mesh.faces) {
    if (std::any_of(face.begin(), face.end(), [&](Index v) { return is_out[std::size_t(v)] != 0; }))
      continue;
    for (Index& v : face) {
      Index& n = number[static_cast<std::size_t>(v)];
      if (n < 0) {
        n = static_cast<Index>(rest.positions.size());
        rest.positions.push_back(mesh.position(v));
      }
      v = n;
    }
    rest.faces.push_back(face);
  }
  return rest;
}

}  // namespace scans

/// Twenty-four such meshes, the same ones every time: of about 2,600 vertices at level 4, four
/// times as many a level.
inline std::vector<NamedMesh> scan_meshes(int level = 4) {
  using namespace scans;
  Random random(20);
  const auto side = static_cast<Index>(50 << std::max(0, level - 4)) >> std::max(0, 4 - level);
  const std::vector<NamedMesh> shapes{
      {"blob", blob(level)}, {"creased", creased(level)}, {"terrain", terrain(side, random)}};
  std::vector<NamedMesh> all;
  for (const auto& [name, mesh] : shapes) {
    const double size = name == "terrain" ? side : 2;
    all.push_back({name, mesh});
    all.push_back({name + ", noise 0.1", noisy(mesh, 0.1, random)});
    all.push_back({name + ", noise 0.3", noisy(mesh, 0.3, random)});
    all.push_back({name + ", stretched 5", stretched(mesh, 5)});
    all.push_back({name + ", slivers", with_slivers(mesh, 3, random)});
    all.push_back(
        {name + ", slivers, noise 0.1", noisy(with_slivers(mesh, 3, random), 0.1, random)});
    all.push_back({name + ", holes", with_holes(mesh, 8, 0.1 * size, random)});
    all.push_back(
        {name + ", holes, noise, slivers, stretched 3",
         stretched(
             with_slivers(noisy(with_holes(mesh, 8, 0.07 * size, random), 0.1, random), 4, random),
             3)});
  }
  return all;
}

}  // namespace gelight::test
