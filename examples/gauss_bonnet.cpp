// Gauss and Bonnet: bend a surface as you like, its curvature sums to the same.
//
//       \  |  /        Cut open along an edge and laid flat, the triangles round a vertex lack an
//        \ | /  |      angle (a tip), overlap (a saddle), or fit (flat). That angle defect, 2 pi
//     ----\|/___|      less the sum of the angles, is the curvature that the mesh has there. Summed
//         /|\ defect   over a closed surface it is 2 pi (V - E + F): 4 pi for all that is like a
//        / | \         sphere, 0 for all that is like a ring, however dented. With a border the
//                      border's turning counts, too.

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec3;

// At each vertex: the angle that lacks round it, or by which the border turns there (pi less it).
std::vector<double> angle_defects(const gelight::Surface<double>& surface) {
  std::vector<double> lacks(static_cast<std::size_t>(surface.vertex_count()), 2 * std::numbers::pi);
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    const auto at = static_cast<std::size_t>(surface.origin(h));
    const Index next = h % 3 == 2 ? h - 2 : h + 1;
    const Vec3<double> p = surface.position(surface.origin(h));
    const Vec3<double> a = surface.position(surface.tip(h)) - p;
    const Vec3<double> b = surface.position(surface.tip(next)) - p;
    lacks[at] -= std::atan2(gelight::cross<double>(a, b).norm(), a.dot(b));
    if (surface.is_border(h)) {  // half a turn less for its two ends
      lacks[at] -= std::numbers::pi / 2;
      lacks[static_cast<std::size_t>(surface.tip(h))] -= std::numbers::pi / 2;
    }
  }
  return lacks;
}

double total(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "gauss_bonnet");

  auto sphere = gelight::icosphere<double>(4), ring = gelight::torus<double>(1, 0.42, 90, 40);
  auto dented = sphere;
  for (auto& p : dented.positions) {  // waves of a fifth of its radius
    const double wave = 1 + 0.2 * std::sin(4 * p[0] + 1) * std::sin(5 * p[1]) * std::cos(3 * p[2]);
    for (double& x : p) x *= wave;
  }
  const auto tip = gelight::membrane<double>(1, 1.6, 0.1);
  struct Shape {
    std::string name;
    gelight::Mesh<double> mesh;
    double sum;  // in half turns
  };
  const std::vector<Shape> shapes{{"a sphere", sphere, 4},
                                  {"the same, dented", dented, 4},
                                  {"a ring", ring, 0},
                                  {"a fingertip, open", tip, 2}};
  Figure figure(1000, 360);
  double x = 10;
  for (const auto& [name, mesh, expected] : shapes) {
    const gelight::Surface<double> surface(mesh);
    const auto defects = angle_defects(surface);
    const double sum = total(defects) / std::numbers::pi;
    lesson.expect(std::abs(sum - expected) < 1e-9,
                  name + ": the defects sum to " + std::to_string(std::lround(expected)) + " pi");
    // Curvature is the defect by area, a third of the faces'.
    std::vector<double> areas(defects.size(), 0.0), curvature;
    for (Index f = 0; f < surface.face_count(); ++f) {
      const auto [a, b, c] = surface.face(f);
      const double area = gelight::cross<double>(surface.position(b) - surface.position(a),
                                                 surface.position(c) - surface.position(a))
                              .norm() /
                          2;
      for (const Index v : {a, b, c}) areas[static_cast<std::size_t>(v)] += area / 3;
    }
    for (std::size_t v = 0; v < defects.size(); ++v) curvature.push_back(defects[v] / areas[v]);
    for (Index h = 0; h < surface.halfedge_count(); ++h) {  // what turns there is the border
      if (!surface.is_border(h)) continue;
      for (const Index v : {surface.origin(h), surface.tip(h)})
        curvature[static_cast<std::size_t>(v)] = 0;
    }
    const View view(surface, {x + 5, 60, 230, 230}, 0.6, name == "a ring" ? 0.7 : 1.2);
    view.paint(figure, [&](const gelight::SurfacePoint<double>& p) -> Colour {
      const auto corners = surface.face(p.element[0]);
      double k = 0;
      for (std::size_t i = 0; i < 3; ++i)
        k += p.weights[i] * curvature[static_cast<std::size_t>(corners[i])];
      const double share = std::tanh(0.5 * k);
      return share > 0 ? Colour{1, 1 - 0.65 * share, 1 - 0.85 * share}
                       : Colour{1 + 0.85 * share, 1 + 0.55 * share, 1};
    });
    figure.pen(black, 1);
    figure.text(name, x + 120, 26, 17);
    figure.text(std::to_string(std::lround(sum)) + " pi", x + 120, 312, 19);
    x += 245;
  }
  figure.text(
      "Orange: curved like a ball. Blue: like a saddle. Below: the sum of all angle defects.", 500,
      345, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
