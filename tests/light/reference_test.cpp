// The four light fields against those that the authors of the GelTip paper published, at their
// 160 x 120 pixels. What each file holds is told in the reference data's README.

#include <doctest/doctest.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "gelight/views/openmesh.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Surface;
using gelight::Vec3;
using gelight::vertex_point;

namespace {

const std::string folder = std::string(GELIGHT_REFERENCE_DIR) + "/geltip/";

bool is_absent() {
  if (std::filesystem::exists(folder)) return false;
  MESSAGE("skipped: there is no reference data in " << folder);
  return true;
}

Surface<double> membrane() {
  OpenMesh::TriMesh_ArrayKernelT<> mesh;
  REQUIRE(OpenMesh::IO::read_mesh(mesh, folder + "membrane.stl"));
  const Surface<double> surface(mesh);
  REQUIRE(surface.vertex_count() == 14124);
  REQUIRE(surface.face_count() == 28244);
  return surface;
}

struct Pixel {
  Index x, y;
  Vec3<double> position;
};

// The pixels of the authors' circular mask, and the points that they see.
std::vector<Pixel> masked_pixels() {
  const auto rest = gelight::read_npy<float>(folder + "depth/rest.npy");
  const auto small = gelight::resize_bilinear(rest, 160, 120);
  const auto camera = gelight::Camera<double>::from_vertical_fov(std::numbers::pi / 2, 160, 120);
  std::vector<Pixel> pixels;
  for (Index y = 0; y < 120; ++y) {
    for (Index x = 0; x < 160; ++x) {
      if ((x - 80) * (x - 80) + (y - 60) * (y - 60) > 60 * 60) continue;
      pixels.push_back({x, y, camera.unproject(x, y, small(x, y))});
    }
  }
  return pixels;
}

Image<Vec3<double>> stored(const std::string& method, std::size_t led) {
  return gelight::read_npy<Vec3<double>>(folder + "field/" + method + "_led" +
                                               std::to_string(led) + ".npy");
}

// The vertices that the authors' code took for the LEDs.
constexpr std::array<std::array<double, 3>, 3> led_vertices{{{0.01148598, 0.00048878, 0.0005},
                                                             {-0.00594523, 0.00980506, -0.0005},
                                                             {-0.00596125, -0.00982559, 0.0005}}};

Index led_vertex(const Surface<double>& surface, std::size_t led) {
  const auto& [x, y, z] = led_vertices[led];
  const Vec3<double> place(x, y, z);
  const Index v = gelight::nearest_vertex(surface, place);
  REQUIRE((surface.position(v) - place).norm() < 1e-7);
  return v;
}

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(gelight::cross(a, b).norm(), a.dot(b));
}

void report(const std::string& what, std::vector<double> angles) {
  std::sort(angles.begin(), angles.end());
  const auto degrees = [&](double share) {
    const auto i = static_cast<std::size_t>(share * static_cast<double>(angles.size() - 1));
    return angles[i] * 180 / std::numbers::pi;
  };
  const auto beyond = [&](double limit) {
    const auto first =
        std::upper_bound(angles.begin(), angles.end(), limit * std::numbers::pi / 180);
    return 100.0 * static_cast<double>(angles.end() - first) / static_cast<double>(angles.size());
  };
  MESSAGE(what << ": angle to the published field, degrees: median " << degrees(0.5) << ", 90 % "
               << degrees(0.9) << ", largest " << degrees(1) << "; beyond 2 degrees " << beyond(2)
               << " %, beyond 90 degrees " << beyond(90) << " %");
}

}  // namespace

TEST_CASE("the linear field is the published one") {
  if (is_absent()) return;
  for (std::size_t led = 0; led < 3; ++led) {
    const auto expected = stored("linear", led);
    const double turn = 2 * std::numbers::pi / 3 * static_cast<double>(led);
    const Vec3<double> place(0.012 * std::cos(turn), 0.012 * std::sin(turn), 0);
    double worst = 0;
    for (const Pixel& pixel : masked_pixels()) {
      const auto field = gelight::linear_field<double>(place, std::span(&pixel.position, 1));
      worst = std::max(worst, (field[0] - expected(pixel.x, pixel.y)).cwiseAbs().maxCoeff());
    }
    CHECK(worst < 1e-15);
  }
}

TEST_CASE("the geodesic field is the published one wherever one shortest path arrives") {
  if (is_absent()) return;
  const auto surface = membrane();
  const gelight::ExactSolver<double> solver(surface);
  for (std::size_t led = 0; led < 3; ++led) {
    CAPTURE(led);
    const auto expected = stored("geodesic", led);
    const auto pixels = masked_pixels();
    std::vector<gelight::SurfacePoint<double>> targets;
    for (const Pixel& pixel : pixels) {
      targets.push_back(vertex_point<double>(gelight::nearest_vertex(surface, pixel.position)));
    }
    const auto led_point = vertex_point<double>(led_vertex(surface, led));
    const auto field = gelight::geodesic_field<double>(solver, led_point, targets);
    const auto exact = solver.solve(led_point.element[0]);
    std::size_t compared = 0, ties = 0;
    double worst = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Vec3<double> direction = expected(pixels[i].x, pixels[i].y);
      if (direction.isZero()) continue;
      ++compared;
      const double off = (field[i] - direction.normalized()).norm();
      if (off > 1e-9 && exact.arrivals(targets[i].element[0], 1e-9).size() > 1) {
        ++ties;
        continue;
      }
      worst = std::max(worst, off);
    }
    CHECK(compared == 11288);
    CHECK(worst < 1e-9);
    MESSAGE("LED " << led << ": worst difference " << worst << ", " << ties << " of " << compared
                   << " pixels took the other of two equally short paths");
    CHECK(ties < compared / 100);
  }
}

// These two are reported, not compared: the published plane field has part of its segments turned
// round, and the published transport field has lost the signs of its source vector.
TEST_CASE("how far the plane and transport fields are from the published ones") {
  if (is_absent()) return;
  const auto surface = membrane();
  const gelight::VectorHeatSolver<double> heat(surface);
  const auto pixels = masked_pixels();
  std::vector<gelight::SurfacePoint<double>> targets;
  for (const Pixel& pixel : pixels) {
    targets.push_back(vertex_point<double>(gelight::nearest_vertex(surface, pixel.position)));
  }
  for (std::size_t led = 0; led < 3; ++led) {
    const Index source = led_vertex(surface, led);
    const auto compare = [&](const std::string& method, const gelight::LightField<double>& field,
                             const std::string& published) {
      const auto expected = stored(published, led);
      std::vector<double> angles;
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        const Vec3<double> direction = expected(pixels[i].x, pixels[i].y);
        if (direction.isZero() || field[i].isZero()) continue;
        CHECK(field[i].norm() == doctest::Approx(1).epsilon(1e-12));
        angles.push_back(angle(field[i], direction));
      }
      CHECK(angles.size() > pixels.size() * 99 / 100);
      report(method + ", LED " + std::to_string(led), angles);
    };
    compare("plane", gelight::plane_field<double>(surface, vertex_point<double>(source), targets),
            "plane");
    compare("transport of (0, 0, 1)",
            gelight::transport_field<double>(heat, source, {0, 0, 1}, targets), "transport");
    compare("radial transport", gelight::radial_transport_field<double>(heat, source, targets),
            "transport");
  }
}
