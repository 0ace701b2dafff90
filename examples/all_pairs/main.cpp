// The distances between all pairs of a mesh's vertices, a row a source, by any number of machines:
//
//     mesh --> rows, part by part --> all ranks' threads --> out.h5.parts/*.h5 --> out.h5
//
// all_pairs mesh.obj out.h5, or mpirun -n 8 all_pairs mesh.obj out.h5. Killed at any moment and
// started again, it goes on. Where the method is approximate, each row has a certificate: how far
// it can be from the exact distances, at the mean vertex and at the worst.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "../support/mesh_file.hpp"
#include "../support/parted_work.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/light/traced/philox.hpp"
#include "gelight/mesh/shapes.hpp"

using gelight::Index;
using gelight::Mesh;
using gelight::Surface;

namespace {

struct Settings {
  std::string mesh, out, method = "exact", type = "float32";
  double edge = 0.001;
  int rows_a_part = 64, threads = 0;
};

/// Distances of all vertices from one.
using Row = std::function<std::vector<double>(Index)>;

Mesh<double> read_mesh(const Settings& settings) {
  if (settings.mesh == "geltip") return gelight::membrane(0.01146, 0.0455, settings.edge);
  return mesh_of_file(settings.mesh);
}

/// Tells of points that a file has so far from the origin that distances lose digits.
void tell_rounding(const std::string& name, const Mesh<double>& mesh) {
  const Rounding rounding = rounding_of<double>(mesh);
  if (!rounding.exceeds(1e-9)) return;
  std::fprintf(stderr,
               "%s lies %.2g from the origin: its points are rounded by %.2g where edges are %.2g, "
               "and distances are off by as much\n",
               name.c_str(), rounding.farthest, rounding.error, rounding.edge);
}

/// The mesh about the origin: distances between points far away lose digits in every difference.
Mesh<double> centred(Mesh<double> mesh) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [low, high] =
        std::minmax_element(mesh.positions.begin(), mesh.positions.end(),
                            [i](const auto& p, const auto& q) { return p[i] < q[i]; });
    const double middle = (*low)[i] / 2 + (*high)[i] / 2;
    for (auto& p : mesh.positions) p[i] -= middle;
  }
  return mesh;
}

/// Distances in single precision. Throws std::runtime_error, which names the vertices, for one that
/// it cannot hold: an infinite one is none, and 0 is that of the vertex itself.
std::vector<float> rounded(const std::vector<double>& distances, Index source) {
  std::vector<float> all(distances.begin(), distances.end());
  for (std::size_t v = 0; v < all.size(); ++v) {
    const bool is_held = distances[v] == 0 || !std::isfinite(distances[v]) || std::isnormal(all[v]);
    if (!is_held) {
      throw std::runtime_error(gelight::detail::joined(
          "the distance from vertex ", source, " to vertex ", v, " is ", distances[v],
          ", which float32 cannot hold; write elsewhere with --type float64"));
    }
  }
  return all;
}

template <class Solver>
Row row_of(const Surface<double>& surface) {
  const auto solver = std::make_shared<const Solver>(surface);
  return [solver](Index source) { return solver->distance(source); };
}

Row row_by(const std::string& method, const Surface<double>& surface) {
  if (method == "smooth") return row_of<gelight::SmoothDistanceSolver<double>>(surface);
  if (method == "fast_marching") return row_of<gelight::FastMarchingSolver<double>>(surface);
  return row_of<gelight::ExactSolver<double>>(surface);
}

std::vector<Column> columns_of(const Settings& settings, Index vertices) {
  const auto number = settings.type == "float64" ? hdf5::Number::f64 : hdf5::Number::f32;
  std::vector<Column> columns{{"distance", number, {static_cast<hsize_t>(vertices)}},
                              {"position", hdf5::Number::f64, {3}}};
  if (settings.method == "fast_marching") {
    columns.push_back({"certified_error", hdf5::Number::f64, {2}});
  }
  return columns;
}

/// Makes rows, on any thread.
struct Rows {
  const Surface<double>& surface;
  const PartedFile& file;
  Row row;
  std::unique_ptr<gelight::Certifier<double>> certifier;  // of what is approximate

  void make_part(int number) const {
    Part part = file.new_part(number);
    for (std::uint64_t r = 0; r < file.rows_of(number); ++r) {
      const auto source = static_cast<Index>(file.first_row(number) + r);
      const std::vector<double> distances = row(source);
      if (file.columns()[0].number == hdf5::Number::f64) {
        part.put(0, r, std::span<const double>(distances));
      } else {
        part.put(0, r, std::span<const float>(rounded(distances, source)));
      }
      const gelight::Vec3<double> position = surface.position(source);
      part.put(1, r, std::span<const double>(position.data(), 3));
      if (certifier == nullptr) continue;
      const auto error = certifier->bounds(source, distances).error_of(distances);
      const std::array<double, 2> certificate{error.mean, error.max};
      part.put(2, r, std::span<const double>(certificate));
    }
    file.write(number, part);
  }
};

/// Different vertices, picked at random: 32, or all where there are no more.
std::vector<std::size_t> some_vertices(Index vertices) {
  const auto count = static_cast<std::size_t>(vertices);
  std::set<std::size_t> picked;
  for (std::uint64_t i = 0; picked.size() < std::min<std::size_t>(32, count); ++i) {
    const double share = gelight::detail::uniforms(1, i, 0)[0];
    picked.insert(static_cast<std::size_t>(static_cast<double>(count) * share));
  }
  return {picked.begin(), picked.end()};
}

/// The most by which the distances there and back differ, as a share of the larger one, between
/// any two of these vertices.
double asymmetry(const std::string& out, const std::vector<std::size_t>& of) {
  const auto guard = hdf5::lock();
  const hdf5::ReadFile file(out);
  std::vector<std::vector<double>> rows;
  for (const std::size_t v : of) {
    const auto row = file.row<double>("distance", v);
    rows.emplace_back();
    for (const std::size_t other : of) rows.back().push_back(row[other]);
  }
  double worst = 0;
  for (std::size_t i = 0; i < of.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double there = rows[i][j], back = rows[j][i];
      if (there == back) continue;  // both infinite, say
      const double share = std::abs(there - back) / std::max(there, back);
      worst =
          std::isfinite(share) ? std::max(worst, share) : std::numeric_limits<double>::infinity();
    }
  }
  return worst;
}

void finish(const PartedFile& file, const Settings& settings, Index vertices) {
  file.finish({{"mesh", settings.mesh}, {"method", settings.method}});
  const auto of = some_vertices(vertices);
  const double share = asymmetry(settings.out, of);
  std::printf("there and back differ by %.2g of the distance at most, over %zu random pairs\n",
              share, of.size() * (of.size() - 1) / 2);
  // The exact distance is symmetric but for rounding; the others are by as much as they are off.
  const double most = settings.type == "float64" ? 1e-9 : 1e-6;
  if (settings.method == "exact" && !(share <= most)) {
    throw std::runtime_error(
        gelight::detail::joined("the exact distances there and back differ by ", share));
  }
}

std::string description(const Settings& settings, const Surface<double>& surface) {
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&](const auto& value) {
    for (const std::byte b : std::as_bytes(std::span(&value, 1))) {
      hash = (hash ^ static_cast<std::uint64_t>(b)) * 1099511628211U;
    }
  };
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    for (Index i = 0; i < 3; ++i) add(surface.position(v)[i]);
  }
  for (Index f = 0; f < surface.face_count(); ++f) add(surface.face(f));
  return settings.method + " " + settings.type + " mesh " + std::to_string(hash);
}

void run(const Ranks& ranks, const Settings& settings) {
  const Mesh<double> mesh = read_mesh(settings);
  if (ranks.is_first()) tell_rounding(settings.mesh, mesh);
  const Surface<double> surface(mesh);
  const Surface<double> about_origin(centred(mesh));
  const Index vertices = surface.vertex_count();
  PartedFile file(settings.out, description(settings, surface), columns_of(settings, vertices),
                  static_cast<std::uint64_t>(vertices),
                  static_cast<std::uint64_t>(settings.rows_a_part));
  Rows rows{surface, file, row_by(settings.method, about_origin), nullptr};
  if (settings.method == "fast_marching") {
    rows.certifier = std::make_unique<gelight::Certifier<double>>(about_origin);
  }
  make_missing_parts(ranks, file, settings.threads, "rows",
                     [&](int number, int) { rows.make_part(number); });
  (void)ranks.sum({0});  // all are done
  if (ranks.is_first()) finish(file, settings, vertices);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CommandLine line("Writes the distances between all pairs of a mesh's vertices into an HDF5 file.",
                   "all_pairs");
  line.add_required("mesh", settings.mesh, "a file, or geltip");
  line.add_required("out", settings.out, "the HDF5 file; its parts go beside it");
  line.add_within("--edge", settings.edge, 0.0001, 0.02, "edge length of geltip's mesh, metres");
  line.add_one_of("--method", settings.method, {"exact", "smooth", "fast_marching"},
                  "how distances are found");
  line.add_one_of("--type", settings.type, {"float32", "float64"}, "of the numbers");
  line.add_within("--part", settings.rows_a_part, 1, 1000000000, "rows a file");
  hdf5::be_quiet();
  return run_on_ranks(argc, argv, line, settings.threads,
                      [&](const Ranks& ranks) { run(ranks, settings); });
}
