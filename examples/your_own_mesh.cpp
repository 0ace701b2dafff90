// Your own mesh type: one type and four functions tell gelight how to read it; no copy in another
// format is needed.
//
//      Terrain                      MeshTraits<Terrain>              any solver
//      .-------------------.        vertex_count, position           ExactSolver solver(terrain);
//      | heights in a grid |  --->  face_count, face           --->  solver.distance(0)
//      '-------------------'
//
// The terrain below stores no triangles at all: it makes them up when asked.

#include <cmath>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

// --- your code: a map of heights, one every 100 m ------------------------------------------------

struct Terrain {
  int columns = 0, rows = 0;
  std::vector<float> heights;  // metres, row after row
};

// --- what gelight needs to know of it ------------------------------------------------------------

template <>
struct gelight::MeshTraits<Terrain> {
  using Scalar = double;
  static int vertex_count(const Terrain& t) { return t.columns * t.rows; }
  static int face_count(const Terrain& t) { return 2 * (t.columns - 1) * (t.rows - 1); }
  static std::array<double, 3> position(const Terrain& t, Index v) {
    return {100.0 * (v % t.columns), 100.0 * (v / t.columns),
            t.heights[static_cast<std::size_t>(v)]};
  }
  static std::array<Index, 3> face(const Terrain& t, Index f) {
    const Index cell = f / 2, a = cell / (t.columns - 1) * t.columns + cell % (t.columns - 1);
    const Index b = a + 1, c = a + t.columns, d = c + 1;
    return f % 2 == 0 ? std::array{a, b, d} : std::array{a, d, c};
  }
};

static_assert(gelight::TriangleMesh<Terrain>);

// -------------------------------------------------------------------------------------------------

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "your_own_mesh");

  Terrain terrain{90, 60, {}};
  for (int y = 0; y < terrain.rows; ++y) {
    for (int x = 0; x < terrain.columns; ++x) {
      const double ridge = std::exp(-std::pow((x - 45 - 6 * std::sin(y / 9.0)) / 8.0, 2));
      const double pass = 1 - 0.8 * std::exp(-std::pow((y - 14) / 7.0, 2));
      terrain.heights.push_back(
          static_cast<float>(3000 * ridge * pass + 150 * std::sin(x / 4.0) * std::cos(y / 5.0)));
    }
  }
  const gelight::ExactSolver solver(terrain);
  const gelight::Surface<double>& surface = solver.surface();
  const gelight::Index start = 40 * 90 + 10, goal = 35 * 90 + 80;
  const auto field = solver.solve(start);
  const auto path = field.path(goal);

  gelight::Mesh<double> copy;  // the mesh type that comes with gelight
  for (gelight::Index v = 0; v < surface.vertex_count(); ++v) {
    const auto& p = surface.position(v);
    copy.positions.push_back({p[0], p[1], p[2]});
  }
  for (gelight::Index f = 0; f < surface.face_count(); ++f) copy.faces.push_back(surface.face(f));
  lesson.expect(gelight::ExactSolver(copy).distance(start) == field.distances(),
                "distances are the same to the last bit as those of gelight's own mesh type");
  const double straight = (surface.position(goal) - surface.position(start)).norm();
  lesson.expect(field.distance(goal) > straight, "the way over land is longer than the flight");
  lesson.expect(std::abs(gelight::length(surface, path) / field.distance(goal) - 1) < 1e-12,
                "the path is as long as the distance");

  Figure figure(1000, 560);
  const View view(terrain, {30, 60, 940, 440}, 0, 0.5);
  view.paint_bands(figure, field.distances(), 500, 10500);
  figure.pen(red, 3.5);
  view.draw_path(figure, gelight::positions(surface, path));
  view.draw_dot(figure, surface.position(start), 7);
  view.draw_dot(figure, surface.position(goal), 7);
  figure.pen(black, 1);
  figure.text("The shortest way over the mountains", 500, 26, 18);
  figure.text(
      "A new colour every 500 m of way from the left dot. The terrain is the caller's own type.",
      500, 535, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
