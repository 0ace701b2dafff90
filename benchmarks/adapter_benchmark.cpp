// What it costs to bring a mesh or an image of one's own: each adapter beside its twin over packed
// arrays, turn by turn in one run. `ratio` is the median of the adapter's time over the twin's; a
// result that differs from the twin's is an error.

#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <cstddef>
#include <ctime>
#include <vector>

#include "gelight/image/filter.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/views/eigen.hpp"
#include "gelight/views/openmesh.hpp"
#if __has_include(<CGAL/Surface_mesh.h>)
#include <CGAL/Simple_cartesian.h>

#include "gelight/views/cgal.hpp"
#endif

namespace {

using namespace gelight;

template <class Work>
double seconds(const Work& work) {
  const std::clock_t start = std::clock();  // of this process alone, whatever else runs
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Runs the twin and the adapter in turn, and reports how their times compare.
template <class Twin, class Adapter>
void compare(benchmark::State& state, const Twin& twin, const Adapter& adapter) {
  std::vector<double> ratios;
  for (auto _ : state) {
    const double plain = seconds(twin), adapted = seconds(adapter);
    ratios.push_back(adapted / plain);
    state.SetIterationTime(adapted);
  }
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  state.counters["ratio"] = *middle;
}

// Meshes: the cost of a Surface, which is what every solver makes of a mesh once.

const Mesh<double>& plain_mesh() {
  static const auto mesh = icosphere<double>(6);
  return mesh;
}

template <class Adapted>
void compare_meshes(benchmark::State& state, const Adapted& adapted) {
  const Surface<double> expected(plain_mesh()), surface(adapted);
  for (Index v = 0; v < expected.vertex_count(); ++v) {
    if (surface.position(v) != expected.position(v)) return state.SkipWithError("another mesh");
  }
  compare(
      state, [] { benchmark::DoNotOptimize(Surface<double>(plain_mesh())); },
      [&] { benchmark::DoNotOptimize(Surface<double>(adapted)); });
}

void mesh_view(benchmark::State& state) { compare_meshes(state, MeshView<double>(plain_mesh())); }

void mesh_eigen(benchmark::State& state) {
  const auto& mesh = plain_mesh();
  Eigen::MatrixXd v(mesh.positions.size(), 3);
  Eigen::MatrixXi f(mesh.faces.size(), 3);
  for (Eigen::Index i = 0; i < v.rows(); ++i) {
    v.row(i) = Eigen::RowVector3d::Map(mesh.positions[static_cast<std::size_t>(i)].data());
  }
  for (Eigen::Index i = 0; i < f.rows(); ++i) {
    f.row(i) = Eigen::RowVector3i::Map(mesh.faces[static_cast<std::size_t>(i)].data());
  }
  compare_meshes(state, eigen_mesh(v, f));
}

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};

void mesh_openmesh(benchmark::State& state) {
  OpenMesh::TriMesh_ArrayKernelT<DoubleTraits> mesh;
  for (const auto& [x, y, z] : plain_mesh().positions) mesh.add_vertex({x, y, z});
  for (const auto& [a, b, c] : plain_mesh().faces) {
    mesh.add_face(OpenMesh::VertexHandle(a), OpenMesh::VertexHandle(b), OpenMesh::VertexHandle(c));
  }
  compare_meshes(state, mesh);
}

BENCHMARK(mesh_view)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(mesh_eigen)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(mesh_openmesh)->UseManualTime()->Unit(benchmark::kMillisecond);

#if __has_include(<CGAL/Surface_mesh.h>)
void mesh_cgal(benchmark::State& state) {
  using Point = CGAL::Simple_cartesian<double>::Point_3;
  CGAL::Surface_mesh<Point> mesh;
  const auto vertex = [](Index v) { return CGAL::SM_Vertex_index(static_cast<unsigned>(v)); };
  for (const auto& [x, y, z] : plain_mesh().positions) mesh.add_vertex(Point(x, y, z));
  for (const auto& [a, b, c] : plain_mesh().faces) mesh.add_face(vertex(a), vertex(b), vertex(c));
  compare_meshes(state, mesh);
}
BENCHMARK(mesh_cgal)->UseManualTime()->Unit(benchmark::kMillisecond);
#endif

// Images: the cost of a Gaussian that reads someone else's rows.

constexpr Index width = 640, height = 480;

Image<float> plain_image() {
  Image<float> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) image(x, y) = static_cast<float>((x * y) % 17);
  }
  return image;
}

void compare_images(benchmark::State& state, ImageView<float> adapted) {
  const Image<float> plain = plain_image();
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) adapted(x, y) = plain(x, y);
  }
  if (gaussian(adapted, 5, 20) != gaussian(plain, 5, 20)) {
    return state.SkipWithError("another image");
  }
  compare(
      state, [&] { benchmark::DoNotOptimize(gaussian(plain, 5, 20)); },
      [&] { benchmark::DoNotOptimize(gaussian(adapted, 5, 20)); });
}

void image_padded(benchmark::State& state) {
  std::vector<float> pixels(700 * height);
  compare_images(state, {pixels.data(), width, height, 700});
}

void image_upside_down(benchmark::State& state) {
  std::vector<float> pixels(width * height);
  compare_images(state, {pixels.data() + (height - 1) * width, width, height, -width});
}

void image_interleaved(benchmark::State& state) {
  std::vector<float> pixels(3 * width * height);
  compare_images(state, {pixels.data() + 1, width, height, 3 * width, 3});
}

void image_eigen(benchmark::State& state) {
  Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> pixels(height, width);
  compare_images(state, eigen_image(pixels));
}

BENCHMARK(image_padded)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(image_upside_down)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(image_interleaved)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(image_eigen)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
