// A path and its straightness: the spider and the fly (H. E. Dudeney, 1903).
//
//       .-----------------------------.      A room of 30 x 12 x 12 feet. The spider s sits on one
//      / s                           /|      end wall, a foot below the ceiling, the fly f on the
//     +-----------------------------+ |      other, a foot above the floor. Over the ceiling the
//     |                           f | /      way is 1 + 30 + 11 = 42 feet. The shortest way takes
//     +-----------------------------+        five of the six walls. Laid flat one beside the other
//                                            they fit along a straight line, 40 feet long.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec2;
using gelight::Vec3;
using Point = gelight::SurfacePoint<double>;

// Whether a point lies in a face or on its border.
bool is_on(const gelight::Surface<double>& surface, Index face, const Point& point) {
  if (point.kind == Point::Kind::face) return point.element[0] == face;
  const auto corners = surface.face(face);
  return std::all_of(point.element.begin(), point.element.end(), [&](Index v) {
    return v < 0 || std::find(corners.begin(), corners.end(), v) != corners.end();
  });
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "path_straightness");

  const auto room = gelight::box<double>(30, 12, 12);  // about the origin
  const gelight::ExactSolver solver(room);
  const gelight::Surface<double>& surface = solver.surface();
  const Point spider = gelight::nearest_point<double>(surface, {-15, 0, 5});
  const Point fly = gelight::nearest_point<double>(surface, {15, 0, -5});
  const auto field = solver.solve(spider);
  const gelight::Path<double> path = field.path(fly);
  const auto points = gelight::positions(surface, path);
  lesson.expect(std::abs(field.distance(fly) - 40) < 1e-12, "the fly is 40 feet away");
  lesson.expect(std::abs(gelight::length(surface, path) - 40) < 1e-12, "and the path is as long");

  // Lay each triangle that the path crosses so that its piece of the path continues along the x
  // axis. The path is straight if every triangle then fits the one before: no turn at the edge.
  std::vector<std::map<Index, Vec2<double>>> flat;  // of each triangle: where its vertices lie
  std::vector<std::size_t> walls;
  double so_far = 0, misfit = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    Index face = 0;
    while (!is_on(surface, face, path[i]) || !is_on(surface, face, path[i + 1])) ++face;
    walls.push_back(static_cast<std::size_t>(face / 2));
    const auto [a, b, c] = surface.face(face);
    const Vec3<double> normal = gelight::cross<double>(surface.position(b) - surface.position(a),
                                                       surface.position(c) - surface.position(a));
    const Vec3<double> along = (points[i + 1] - points[i]).normalized();
    const Vec3<double> across = gelight::cross<double>(normal.normalized(), along);
    std::map<Index, Vec2<double>> corners;
    for (const Index v : {a, b, c}) {
      const Vec3<double> from_piece = surface.position(v) - points[i];
      corners[v] = {so_far + from_piece.dot(along), from_piece.dot(across)};
      if (i > 0 && flat.back().contains(v)) {
        misfit = std::max(misfit, (corners[v] - flat.back()[v]).norm());
      }
    }
    flat.push_back(corners);
    so_far += (points[i + 1] - points[i]).norm();
  }
  lesson.expect(misfit < 1e-12, "laid flat along the path the walls fit: it is straight");

  Figure figure(1100, 430);
  const std::array inks{green, blue, orange, orange, red, red};
  const std::array names{"floor", "ceiling", "side wall", "side wall", "end wall", "end wall"};
  const View view(room, {20, 80, 420, 330}, -0.45, 1.15);
  const auto on_flat = [](double along, double across) {
    return Vec2<double>(600 + 9 * along, 260 - 9 * across);
  };
  for (std::size_t i = 0; i < flat.size(); ++i) {
    std::vector<Vec2<double>> in_room, laid_flat;
    for (const auto& [v, p] : flat[i]) {
      in_room.push_back(view.on_page(surface.position(v)));
      laid_flat.push_back(on_flat(p[0], p[1]));
    }
    figure.area(in_room, inks[walls[i]], 0.2);
    figure.area(laid_flat, inks[walls[i]], 0.2);
  }
  figure.pen(grey, 1);
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    const auto &from = surface.position(surface.origin(h)), &to = surface.position(surface.tip(h));
    if (((to - from).array() != 0).count() > 1) continue;  // a diagonal of a wall
    figure.polyline(std::array{view.on_page(from), view.on_page(to)});
  }
  double x = 0;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const double end = x + (points[i + 1] - points[i]).norm();
    figure.pen(inks[walls[i]], 5);
    figure.polyline(std::array{on_flat(x, 0), on_flat(end, 0)});
    figure.polyline(std::array{view.on_page(points[i]), view.on_page(points[i + 1])});
    x = end;
  }
  for (std::size_t i = 0; i < flat.size(); ++i) {
    if (i > 0 && walls[i] == walls[i - 1]) continue;
    Vec2<double> middle = Vec2<double>::Zero();
    double lowest = 0;
    for (const auto& [v, p] : flat[i]) {
      middle += p / 3;
      lowest = std::min(lowest, p[1]);
    }
    const bool is_small = walls[i] >= 4;  // an end wall: the name stands below it
    figure.pen(inks[walls[i]], 1);
    figure.text(names[walls[i]], on_flat(middle[0], is_small ? lowest - 1.5 : middle[1]), 15);
  }
  figure.pen(black, 1);
  for (const auto& [p, name] : {std::pair(0, "spider"), std::pair(1, "fly")}) {
    const Vec2<double> in_room = view.on_page(p == 0 ? points.front() : points.back());
    const Vec2<double> laid_flat = on_flat(40.0 * p, 0);
    figure.disc(in_room[0], in_room[1], 5);
    figure.disc(laid_flat[0], laid_flat[1], 5);
    figure.text(name, in_room[0] + (p == 0 ? -14 : 12), in_room[1] - (p == 0 ? 24 : 16), 15);
    figure.text(name, laid_flat[0] + (p == 0 ? -34 : 22), laid_flat[1], 15);
  }
  figure.text("The shortest way in the room", 230, 30, 17);
  figure.text("Laid flat, it is straight: 40 feet", 785, 30, 17);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
