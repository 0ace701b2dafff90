// Voronoi cells: which source is nearest, and where that changes.
//
//      a .    |    . b       Points as far from one source as from another lie on a line between
//             |              their cells: straight on paper, if both start at once. If one starts
//      a .     \\   . b       later, the other has come farther by then, and the line is a branch
//               |            of a hyperbola round the late one. On a curved surface each face sees
//               /            its own pieces of such branches, and a cell can meet itself.
//
// Where three cells meet, their three sources are equally far. On all that is like a ball corners
// less lines plus cells sum to 2, as Euler found.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact_voronoi.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/voronoi.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec3;
using Field = gelight::ExactField<double>;
using Lines = std::vector<gelight::VoronoiEdge<double>>;
using Source = gelight::Source<double>;

void draw_lines(Figure& figure, const View& view, const Lines& lines, Colour ink) {
  figure.pen(ink, 3);
  for (const auto& line : lines)
    view.draw_path(figure, gelight::positions(view.surface(), line.points));
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "cells_of_sources");
  Figure figure(1000, 500);

  // Two sources on paper, the second later and later.
  const auto paper = gelight::grid<double>(12, 12, 4, 4);
  const gelight::ExactSolver on_paper(paper);
  const Vec3<double> a(1, 2, 0), b(3, 2, 0);
  const View flat(paper, {20, 60, 440, 390});
  flat.paint(figure, [](const auto&) { return pale; });
  const std::array<Colour, 4> inks{black, violet, blue, red};
  for (std::size_t i = 0; i < inks.size(); ++i) {
    const double later = 0.5 * static_cast<double>(i);
    const std::array<Source, 2> sources{
        Source{gelight::nearest_point(on_paper.surface(), a), 0},
        Source{gelight::nearest_point(on_paper.surface(), b), later}};
    const Field field = on_paper.solve(std::span<const Source>(sources), {.keep_windows = true});
    const Lines lines = gelight::exact_voronoi_edges(field);
    double off = 0, bent = 0;
    for (const auto& line : lines) {
      for (const Vec3<double>& p : gelight::positions(on_paper.surface(), line.points)) {
        off = std::max(off, std::abs((p - a).norm() - (p - b).norm() - later));
        bent = std::max(bent, std::abs(p[0] - 2));
      }
    }
    if (i == 0) lesson.expect(bent < 1e-12, "two sources at once: a straight line between them");
    if (i == 3) {
      lesson.expect(lines.size() == 1 && off < 1e-12,
                    "one later than the other: a branch of a hyperbola");
    }
    draw_lines(figure, flat, lines, inks[i]);
  }
  figure.pen(black, 1);
  flat.draw_dot(figure, a, 5, "a");
  flat.draw_dot(figure, b, 5, "b");

  // Twelve on an egg, as far apart as they come.
  auto egg = gelight::icosphere<double>(4);
  for (auto& [x, y, z] : egg.positions) x *= 1.5, z *= 0.8;
  const gelight::ExactSolver on_egg(egg);
  const std::vector<Index> sites = gelight::farthest_points(on_egg, 12);
  const Field field = on_egg.solve(sites, {.keep_windows = true});
  const Lines lines = gelight::exact_voronoi_edges(field);
  const std::vector<Field> alone = [&] {
    std::vector<Field> out;
    for (const Index site : sites) out.push_back(on_egg.solve(site, {.keep_windows = true}));
    return out;
  }();
  double unequal = 0;
  bool are_corners = true;
  for (const auto& line : lines) {
    for (const auto& p : line.points) {
      const auto to = [&](Index k) { return alone[static_cast<std::size_t>(k)].distance(p); };
      unequal = std::max(unequal, std::abs(to(line.sources[0]) - to(line.sources[1])));
    }
    for (const auto& end : {line.points.front(), line.points.back()}) {
      std::vector<double> to;
      for (const Field& one : alone) to.push_back(one.distance(end));
      std::sort(to.begin(), to.end());
      are_corners = are_corners && to[2] - to[0] < 1e-9;
    }
  }
  lesson.expect(unequal < 1e-9,
                "on an egg, too, a line is as far from one source as from the other");
  lesson.expect(are_corners, "each line ends where three sources are equally far");
  // Three lines at each corner, two corners to each line.
  const auto sides = static_cast<Index>(lines.size()), cells = static_cast<Index>(sites.size());
  lesson.expect(3 * (2 - cells + sides) == 2 * sides, "corners less lines plus cells sum to 2");

  const View view(egg, {520, 60, 460, 390}, 0.3, 0.9);
  const std::array<Colour, 6> tints{{{0.98, 0.82, 0.65},
                                     {0.72, 0.86, 0.95},
                                     {0.80, 0.93, 0.74},
                                     {0.96, 0.78, 0.82},
                                     {0.88, 0.82, 0.95},
                                     {0.97, 0.94, 0.70}}};
  view.paint(figure, [&](const gelight::SurfacePoint<double>& p) {
    std::size_t least = 0;
    double best = alone[0].distance(p);
    for (std::size_t k = 1; k < alone.size(); ++k) {
      const double d = alone[k].distance(p);
      if (d < best) best = d, least = k;
    }
    return tints[least % tints.size()];
  });
  draw_lines(figure, view, lines, black);
  figure.pen(red, 1);
  for (const Index site : sites) view.draw_dot(figure, on_egg.surface().position(site));
  figure.pen(black, 1);
  figure.text("b starts later by 0, a half, 1, one and a half", 240, 30, 16);
  figure.text("Twelve sources on an egg", 750, 30, 16);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
