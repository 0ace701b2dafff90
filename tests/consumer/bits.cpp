// Prints every bit of what gelight computes, so that the compiled library can be held against the
// headers.

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <gelight/gelight.hpp>
#include <span>
#include <vector>

namespace {

std::uint64_t hash = 0;

void add(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211U;
}

template <class T>
void add(const std::vector<T>& values) {
  if (!values.empty()) add(values.data(), values.size() * sizeof(T));
}

void print(const char* what) {
  std::printf("%s %016llx\n", what, static_cast<unsigned long long>(hash));
  hash = 0;
}

template <class T, class Solver>
void distances(const char* name, const Solver& solver) {
  const std::vector<gelight::Source<T>> sources{
      {gelight::face_point<T>(7, {T(0.5), T(0.25), T(0.25)}), T(0.01)},
      {gelight::vertex_point<T>(3), 0}};
  add(solver.distance(gelight::Index{0}));
  add(solver.distance(std::span<const gelight::Source<T>>(sources)));
  print(name);
}

template <class T>
void solve() {
  auto mesh = gelight::icosphere<T>(3);
  for (auto& p : mesh.positions) p[0] *= T(1.5) + p[1] / 4;
  const gelight::ExactSolver exact(mesh);
  distances<T>("exact", exact);
  distances<T>("dijkstra", gelight::DijkstraSolver(mesh));
  distances<T>("fast marching", gelight::FastMarchingSolver(mesh));
  distances<T>("virtual sources", gelight::VirtualSourceSolver(mesh));
  distances<T>("heat", gelight::HeatSolver(mesh));
  add(gelight::DistancePlanner(mesh).solve(gelight::Index{0}).distance);
  print("planner");
  const auto field = exact.solve(gelight::Index{0});
  for (gelight::Index v = 1; v < 600; v += 37) {
    for (const auto& p : field.path(v)) add(p.weights.data(), sizeof p.weights);
    add(field.direction(v).data(), 3 * sizeof(T));
  }
  print("paths");
  const auto marching = gelight::FastMarchingSolver(mesh).distance(gelight::Index{0});
  const auto bounds = gelight::Certifier(mesh).bounds(gelight::Index{0}, marching);
  add(bounds.lower);
  add(bounds.upper);
  print("bounds");

  const auto tip = gelight::geltip<T>(64, 48, T(0.003));
  const auto rest = gelight::rasterize(tip.membrane, tip.camera);
  const gelight::ExactSolver solver(tip.membrane);
  std::vector<gelight::Light<T>> lights;
  for (const auto& led : tip.leds) {
    const auto light = gelight::geodesic_field<T>(solver, led, gelight::pixel_points(rest));
    lights.push_back({.direction = gelight::bake(light, rest)});
  }
  auto depth = rest.depth;
  for (gelight::Index x = 20; x < 40; ++x) depth(x, 24) -= T(0.0005);
  const gelight::TactileRenderer<T> sensor(tip.camera, rest.depth, lights);
  for (const auto& pixel : sensor.render(depth).pixels()) add(pixel.data(), 3);
  print("frame");
}

}  // namespace

int main() {
  solve<float>();
  solve<double>();
}
