// The four light fields against those that the authors of the GelTip paper published, at their
// 160 x 120 pixels. What each file holds is told in the reference data's README.

#include <doctest/doctest.h>

#include <Eigen/LU>
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
#include "gelight/image/raster.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "gelight/views/openmesh.hpp"
#include "support/approx.hpp"

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
  return gelight::read_npy<Vec3<double>>(folder + "field/" + method + "_led" + std::to_string(led) +
                                         ".npy");
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

std::vector<gelight::SurfacePoint<double>> nearest_vertices(const Surface<double>& surface,
                                                            const std::vector<Pixel>& pixels) {
  std::vector<gelight::SurfacePoint<double>> points;
  for (const Pixel& pixel : pixels) {
    points.push_back(vertex_point<double>(gelight::nearest_vertex(surface, pixel.position)));
  }
  return points;
}

// Where a ray from the origin leaves the membrane.
gelight::SurfacePoint<double> hit(const Surface<double>& surface, const Vec3<double>& ray) {
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = surface.face(f);
    Eigen::Matrix3d corners;
    corners << surface.position(a), surface.position(b), surface.position(c);
    const Vec3<double> shares = corners.inverse() * ray;
    if (shares.minCoeff() < 0) continue;
    const Vec3<double> w = shares / shares.sum();
    return gelight::face_point<double>(f, {w[0], w[1], w[2]});
  }
  throw gelight::InvalidInput("the ray leaves through no face");
}

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(gelight::cross(a, b).norm(), a.dot(b));
}

std::vector<double> angles_to(const std::string& method, std::size_t led,
                              const std::vector<Pixel>& pixels,
                              const gelight::LightField<double>& field) {
  const auto expected = stored(method, led);
  std::vector<double> angles;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    CHECK(field[i].norm() == gelight::test::approx(1).epsilon(1e-12));
    angles.push_back(angle(field[i], expected(pixels[i].x, pixels[i].y)));
  }
  return angles;
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

TEST_CASE("the geodesic field is the published one") {
  if (is_absent()) return;
  const auto surface = membrane();
  const gelight::ExactSolver<double> solver(surface);
  const auto pixels = masked_pixels();
  const auto targets = nearest_vertices(surface, pixels);
  for (std::size_t led = 0; led < 3; ++led) {
    CAPTURE(led);
    const auto expected = stored("geodesic", led);
    const auto field = gelight::geodesic_field<double>(
        solver, vertex_point<double>(led_vertex(surface, led)), targets);
    std::size_t compared = 0, ties = 0;
    double worst = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Vec3<double> direction = expected(pixels[i].x, pixels[i].y);
      if (direction.isZero()) continue;
      ++compared;
      const double off = (field[i] - direction.normalized()).norm();
      // Beyond is only the other of two equally short paths; none of these targets has two.
      if (off > 1e-11) {
        ++ties;
      } else {
        worst = std::max(worst, off);
      }
    }
    CHECK(compared == 11288);
    CHECK(ties == 0);
    MESSAGE("LED " << led << ": largest difference " << worst << " over " << compared << " pixels");
  }
}

// The published plane field has part of its segments from the other side of the cut, so that only
// the plane can be compared; the rest is reported.
TEST_CASE("the plane field lies in the published plane for most pixels") {
  if (is_absent()) return;
  const auto surface = membrane();
  const auto pixels = masked_pixels();
  const auto raster = gelight::rasterize(
      surface, gelight::Camera<double>::from_vertical_fov(std::numbers::pi / 2, 160, 120));
  std::vector<gelight::SurfacePoint<double>> targets;
  for (const Pixel& pixel : pixels) {
    targets.push_back(gelight::face_point<double>(raster.face(pixel.x, pixel.y),
                                                  raster.barycentric(pixel.x, pixel.y)));
  }
  for (std::size_t led = 0; led < 3; ++led) {
    const double turn = 2 * std::numbers::pi / 3 * static_cast<double>(led);
    const Vec3<double> out(std::cos(turn), std::sin(turn), 0);
    const auto field = gelight::plane_field<double>(surface, hit(surface, out), out, targets);
    const auto angles = angles_to("plane", led, pixels, field);
    report("plane, LED " + std::to_string(led), angles);
    const auto equal =
        std::count_if(angles.begin(), angles.end(), [](double a) { return a < 1e-3; });
    CHECK(equal > static_cast<std::ptrdiff_t>(pixels.size() / 2));
  }
}

// Reported, not compared: the published transport field has lost the signs of its source vector.
TEST_CASE("how far the transport fields are from the published one") {
  if (is_absent()) return;
  const auto surface = membrane();
  const gelight::VectorHeatSolver<double> heat(surface);
  const auto pixels = masked_pixels();
  const auto targets = nearest_vertices(surface, pixels);
  for (std::size_t led = 0; led < 3; ++led) {
    const Index source = led_vertex(surface, led);
    const std::string name = ", LED " + std::to_string(led);
    const auto along = gelight::transport_field<double>(heat, source, {0, 0, 1}, targets);
    const auto radial = gelight::radial_transport_field<double>(heat, source, targets);
    report("transport of (0, 0, 1)" + name, angles_to("transport", led, pixels, along));
    report("radial transport" + name, angles_to("transport", led, pixels, radial));
  }
}
