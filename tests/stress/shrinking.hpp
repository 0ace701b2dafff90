#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <sstream>
#include <string>

#include "gelight/mesh/check.hpp"
#include "gelight/views/mesh_view.hpp"

// What random tests share: numbers from the environment, and a failing mesh made small and printed.

namespace gelight::stress {

inline int from_environment(const char* name, int otherwise) {
  const char* const value = std::getenv(name);
  return value == nullptr ? otherwise : std::atoi(value);
}

/// Drops faces while what is left still fails, larger shares first; then rounds coordinates.
/// `fails` is asked of meshes that Surface takes only.
template <class Fails>
[[nodiscard]] Mesh<double> shrunk(Mesh<double> mesh, const Fails& fails_on) {
  const auto fails = [&](const Mesh<double>& candidate) {
    return !candidate.faces.empty() && check(candidate).is_accepted() && fails_on(candidate);
  };
  for (std::size_t share = std::max<std::size_t>(1, mesh.faces.size() / 2); share > 0; share /= 2) {
    for (std::size_t first = 0; first < mesh.faces.size();) {
      auto candidate = mesh;
      const auto begin = candidate.faces.begin() + static_cast<std::ptrdiff_t>(first);
      const auto count = std::min(share, mesh.faces.size() - first);
      candidate.faces.erase(begin, begin + static_cast<std::ptrdiff_t>(count));
      if (fails(candidate)) {
        mesh = candidate;
      } else {
        first += share;
      }
    }
  }
  for (const double step : {1.0, 0.1, 0.01, 1e-4}) {
    for (const auto& face : std::vector(mesh.faces)) {
      for (const Index v : face) {
        auto candidate = mesh;
        for (double& x : candidate.positions[static_cast<std::size_t>(v)]) {
          x = std::round(x / step) * step;
        }
        if (fails(candidate)) mesh = candidate;
      }
    }
  }
  return mesh;
}

/// As C++ reads it.
[[nodiscard]] inline std::string literal(const Mesh<double>& mesh) {
  std::ostringstream out;
  out.precision(17);
  const auto list = [&](const auto& rows) {
    out << '{';
    for (std::size_t i = 0; i < rows.size(); ++i) {
      out << (i > 0 ? ", " : "") << '{' << rows[i][0] << ", " << rows[i][1] << ", " << rows[i][2]
          << '}';
    }
    out << '}';
  };
  out << '{';
  list(mesh.positions);
  out << ",\n ";
  list(mesh.faces);
  out << '}';
  return out.str();
}

}  // namespace gelight::stress
