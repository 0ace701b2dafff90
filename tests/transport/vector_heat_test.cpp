#include "gelight/transport/vector_heat.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"

using namespace gelight;
using std::numbers::pi;
using Vec = Vec3<double>;

namespace {

Vec at(const Mesh<double>& mesh, std::size_t v) {
  return {mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]};
}

double angle_between(const Vec& a, const Vec& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

constexpr double degree = pi / 180;

// The least turn that takes one direction to another, not its opposite.
Eigen::Matrix3d turn_between(const Vec& from, const Vec& to) {
  const Vec axis = from.cross(to);
  Eigen::Matrix3d across;
  across << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const double cosine = from.dot(to);
  return cosine * Eigen::Matrix3d::Identity() + across + axis * axis.transpose() / (1 + cosine);
}

struct Worst {
  double mean = 0, max = 0;
  int count = 0;
  void add(double x) {
    mean += (x - mean) / ++count;
    max = std::max(max, x);
  }
};

}  // namespace

TEST_CASE("in a flat sheet a vector of any quadrant stays what it is, from any kind of point") {
  const auto mesh = grid<double>(12, 9, 2.0, 1.0);
  const VectorHeatSolver solver(mesh);
  for (const Vec& v :
       {Vec(1, 2, 0), Vec(-1, 2, 0), Vec(-3, -0.1, 0), Vec(0, -5, 0), Vec(1, 0, 0)}) {
    for (const auto& point :
         {vertex_point<double>(0), vertex_point<double>(40), edge_point<double>(40, 41, 0.3),
          edge_point<double>(41, 40, 0.3), face_point<double>(57, {0.2, 0.5, 0.3})}) {
      const std::vector<VectorSource<double>> sources{{point, v}};
      for (const auto& carried : solver.transport(sources)) CHECK((carried - v).norm() < 1e-12);
    }
  }
}

TEST_CASE("length is kept, the result is tangent, the part along the normal is dropped") {
  const auto mesh = icosphere<double>(3);
  const VectorHeatSolver solver(mesh);
  const auto basis = solver.tangent_basis(9);
  const Vec tangent = 0.3 * basis[0] - 4 * basis[1];
  const auto carried = solver.transport(9, tangent);
  for (std::size_t v = 0; v < carried.size(); ++v) {
    CHECK(carried[v].norm() == gelight::test::approx(tangent.norm()).epsilon(1e-12));
    CHECK(std::abs(carried[v].dot(at(mesh, v))) < 0.02 * tangent.norm());
  }
  CHECK((carried[9] - tangent).norm() < 1e-12);
  const auto lifted = solver.transport(9, tangent + 7 * basis[0].cross(basis[1]));
  for (std::size_t v = 0; v < carried.size(); ++v) {
    if ((at(mesh, v) + at(mesh, 9)).norm() < 1e-9) continue;  // vectors cancel at the antipode
    CHECK((lifted[v] - carried[v]).norm() < 1e-12);
  }
}

TEST_CASE("on spheres: angle to parallel transport along great circles") {
  for (const int level : {3, 4, 5}) {
    const auto mesh = icosphere<double>(level);
    const VectorHeatSolver solver(mesh);
    const Vec pole = at(mesh, 7);
    const Vec start = pole.cross(Vec(0.3, 1, 0.2)).normalized();
    const auto carried = solver.transport(7, start);
    const auto radial = solver.radial(7);
    Worst transport, away;
    for (std::size_t v = 0; v < carried.size(); ++v) {
      const Vec p = at(mesh, v);
      if (v == 7 || (p + pole).norm() < 1e-9) continue;
      const Eigen::Matrix3d turn = turn_between(pole, p);
      transport.add(angle_between(turn * start, carried[v]) / degree);
      away.add(angle_between(turn * (p - p.dot(pole) * pole), radial[v]) / degree);
    }
    MESSAGE("level " << level << ", degrees: transport " << transport.mean << " mean, "
                     << transport.max << " max; radial " << away.mean << ", " << away.max);
    CHECK(transport.mean < 0.15);
    CHECK(transport.max < 0.6);
    CHECK(away.mean < 0.15);
    CHECK(away.max < 0.6);
  }
}

TEST_CASE("holonomy of an octant of the sphere is pi / 2") {
  // Three corners of the octant, each the vertex nearest to an axis of a turned frame.
  const auto mesh = icosphere<double>(5);
  const VectorHeatSolver solver(mesh);
  const auto nearest = [&](const Vec& p) {
    Index best = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      if ((at(mesh, v) - p).norm() < (at(mesh, static_cast<std::size_t>(best)) - p).norm()) {
        best = static_cast<Index>(v);
      }
    }
    return best;
  };
  // The icosahedron's edge midpoints hold three at right angles to each other.
  const std::array<Index, 3> corner{nearest(Vec::UnitX()), nearest(Vec::UnitY()),
                                    nearest(Vec::UnitZ())};
  const Vec start = Vec::UnitY();
  Vec v = start;
  for (std::size_t k = 0; k < 3; ++k) {
    v = solver.transport(corner[k], v)[static_cast<std::size_t>(corner[(k + 1) % 3])];
  }
  CHECK(angle_between(start, v) == gelight::test::approx(pi / 2).epsilon(0.01));
}

TEST_CASE("turning the source vector turns the result; turning the mesh turns all") {
  const auto mesh = torus(2.0, 0.7, 30, 14);
  const VectorHeatSolver solver(mesh);
  const auto basis = solver.tangent_basis(33);
  const auto x = solver.transport(33, basis[0]);
  const auto y = solver.transport(33, basis[1]);
  const auto mixed = solver.transport(33, std::cos(2.5) * basis[0] + std::sin(2.5) * basis[1]);
  for (std::size_t v = 0; v < x.size(); ++v) {
    CHECK((mixed[v] - std::cos(2.5) * x[v] - std::sin(2.5) * y[v]).norm() < 1e-9);
  }
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2, Vec(1, 2, -3).normalized()).toRotationMatrix();
  const VectorHeatSolver turned(placed(mesh, turn, Vec(5, 6, 7)));
  const auto z = turned.transport(33, turn * basis[0]);
  for (std::size_t v = 0; v < x.size(); ++v) CHECK((z[v] - turn * x[v]).norm() < 1e-8);
}

TEST_CASE("several vectors: each near its source, lengths blended") {
  const auto mesh = grid<double>(30, 10, 3.0, 1.0);
  const VectorHeatSolver solver(mesh);
  const std::vector<VectorSource<double>> sources{
      {vertex_point<double>(5 * 31), Vec(1, 0, 0)},
      {vertex_point<double>(5 * 31 + 30), Vec(0, 3, 0)}};
  const auto field = solver.transport(sources);
  CHECK((field[5 * 31 + 3] - Vec(1, 0, 0)).norm() < 1e-6);
  CHECK((field[5 * 31 + 27] - Vec(0, 3, 0)).norm() < 1e-6);
  for (const auto& v : field) {
    CHECK(v.norm() >= 1 - 1e-9);
    CHECK(v.norm() <= 3 + 1e-9);
  }
}

TEST_CASE_TEMPLATE("vectors and values are named in braces", T, float, double) {
  const VectorHeatSolver solver(icosphere<T>(2));
  const VectorSource<T> a{vertex_point<T>(3), {0, 0, 1}}, b{vertex_point<T>(60), {T(0.5), 0, 0}};
  const std::vector<VectorSource<T>> both{a, b};
  CHECK(solver.transport({a, b}) == solver.transport(both));
  CHECK(solver.transport({{vertex_point<T>(3), {0, 0, 1}}, b}) == solver.transport(both));
  CHECK(solver.solve({a, b}).vectors == solver.transport(both));
  const std::vector<Index> at{3, 60};
  const std::vector<T> values{T(0.25), 2};
  const auto extended = solver.extend(at, values);
  CHECK(solver.extend({3, 60}, values) == extended);
  CHECK(solver.extend({3, 60}, {T(0.25), 2}) == extended);
  CHECK_THROWS_AS((void)solver.extend({3, 60}, {T(1)}), InvalidInput);
}

TEST_CASE("what is carried from a border, or much longer, ends halfway to the next source") {
  constexpr Index cells = 32, side = cells + 1, middle = cells / 2;
  const auto mesh = grid<double>(cells, cells, 1.0, 1.0);
  const VectorHeatSolver solver(mesh);
  const auto vertex = [&](Index x, Index y) { return y * side + x; };
  const std::array<std::array<Index, 2>, 4> pairs{{{vertex(0, 0), vertex(middle, middle)},
                                                   {vertex(middle, 0), vertex(middle, middle)},
                                                   {vertex(middle, 0), vertex(0, cells)},
                                                   {vertex(8, middle), vertex(24, middle)}}};
  for (const auto& [a, b] : pairs) {
    const auto extended = solver.extend(std::vector<Index>{a, b}, std::vector<double>{0, 1});
    for (const double length : {1e-6, 1.0, 1e6}) {
      const auto carried = solver.transport(std::vector<VectorSource<double>>{
          {vertex_point<double>(a), {1, 0, 0}}, {vertex_point<double>(b), {0, length, 0}}});
      for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const double to_a = (at(mesh, v) - at(mesh, static_cast<std::size_t>(a))).norm();
        const double to_b = (at(mesh, v) - at(mesh, static_cast<std::size_t>(b))).norm();
        if (std::abs(to_a - to_b) < 0.5 / cells) continue;
        CHECK((extended[v] > 0.5) == (to_b < to_a));
        CHECK((carried[v].y() > carried[v].x()) == (to_b < to_a));
      }
    }
  }
}

TEST_CASE("log map of a flat sheet is the difference of positions") {
  const auto mesh = grid<double>(40, 40);
  const VectorHeatSolver solver(mesh);
  const Index s = 20 * 41 + 20;
  const auto basis = solver.tangent_basis(s);
  const auto map = solver.log_map(s);
  Worst radius, direction;
  for (std::size_t v = 0; v < map.size(); ++v) {
    const Vec truth = at(mesh, v) - at(mesh, static_cast<std::size_t>(s));
    const Vec found = map[v][0] * basis[0] + map[v][1] * basis[1];
    if (v == static_cast<std::size_t>(s)) {
      CHECK(found.norm() == 0);
      continue;
    }
    radius.add(std::abs(found.norm() / truth.norm() - 1));
    direction.add(angle_between(found, truth) / degree);
  }
  MESSAGE("radius off by " << radius.mean << " mean, " << radius.max << " max; direction "
                           << direction.mean << ", " << direction.max << " degrees");
  CHECK(radius.mean < 0.02);
  CHECK(radius.max < 0.06);
  CHECK(direction.mean < 2);
  CHECK(direction.max < 8);
  CHECK((map[static_cast<std::size_t>(s) + 1].norm()) == gelight::test::approx(1.0 / 40));
}

TEST_CASE("extend: a constant stays, values stay in range and near their vertices") {
  const auto mesh = icosphere<double>(4);
  const VectorHeatSolver solver(mesh);
  const std::vector<Index> at{3, 500, 1200};
  const std::vector<double> constant(3, -7.5), values{1, -2, 4};
  for (const double x : solver.extend(at, constant)) CHECK(x == -7.5);
  const auto field = solver.extend(at, values);
  for (const double x : field) {
    CHECK(x >= -2);
    CHECK(x <= 4);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(field[static_cast<std::size_t>(at[k])] == gelight::test::approx(values[k]).epsilon(1e-3));
  }
}

TEST_CASE("extend: a single value is that value to the last bit, from a corner as from a saddle") {
  auto mesh = grid<double>(12, 12, 1.0, 1.0);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (auto& p : mesh.positions) p[2] = noise(random);
  const VectorHeatSolver solver(mesh);
  const double largest = std::numeric_limits<double>::max();
  for (const double value : {0.1, -1.0 / 3, largest, -largest, 4e-320}) {
    for (Index v = 0; v < 144; v += 7) {
      const auto extended = solver.extend(std::vector<Index>{v}, std::vector<double>{value});
      CHECK(std::ranges::all_of(extended, [&](double x) { return x == value; }));
    }
  }
}

TEST_CASE(
    "extend: a value that is given several times at a vertex is that value, no rounding off") {
  const VectorHeatSolver solver(icosphere<double>(1));
  for (const std::vector<Index>& at : {std::vector<Index>{3, 3, 3}, {3, 3, 3, 5}}) {
    const auto extended = solver.extend(at, std::vector<double>(at.size(), 0.1));
    CHECK(std::ranges::all_of(extended, [](double x) { return x == 0.1; }));
  }
}

TEST_CASE("radial directions: of length 1 beyond a face whose corners are equally far") {
  // A flat rhombus, its sides as long as the way from the first corner to the one opposite.
  const Mesh<double> mesh{{{0, 0, 1}, {1, 0, 2}, {0, 1, 0}, {1, 1, 1}}, {{0, 1, 2}, {1, 3, 2}}};
  const VectorHeatSolver solver(mesh);
  const auto radial = solver.radial(0);
  for (std::size_t v = 1; v < 4; ++v) {
    CHECK((radial[v] - (at(mesh, v) - at(mesh, 0)).normalized()).norm() < 1e-12);
  }
}

TEST_CASE("extend and transport keep in range where corners of the border are obtuse") {
  Mesh<double> triangle;
  triangle.positions = {{0, 0, 0}, {2, 0, 0}, {1, 0.5, 0}};
  triangle.faces = {{0, 1, 2}};
  const std::vector<Index> vertices{0, 2};
  const std::vector<double> values{0, 1};
  for (const double time : {1.0, 0.1, 0.03, 0.01}) {
    CAPTURE(time);
    const VectorHeatSolver solver(triangle, {.time_factor = time});
    for (const double x : solver.extend(vertices, values)) {
      CHECK(x >= 0);
      CHECK(x <= 1);
    }
    const std::vector<VectorSource<double>> sources{{vertex_point<double>(0), {1, 0, 0}},
                                                    {vertex_point<double>(2), {2, 0, 0}}};
    for (const auto& v : solver.transport(sources)) {
      CHECK(v.norm() >= 1 - 1e-14);
      CHECK(v.norm() <= 2 + 1e-14);
    }
  }
}

TEST_CASE("vectors and values of any size are carried alike") {
  const auto sphere = icosphere<double>(2);
  const VectorHeatSolver solver(sphere);
  const std::vector<Index> vertices{0, 5};
  const auto extended = solver.extend(vertices, std::vector<double>{1, 2});
  const auto carried = solver.transport(0, Vec(0.3, 0.5, 0.7));
  for (const double scale : {1e-300, 1e-30, 1e36, 1e38, 1e200, 1e307}) {
    CAPTURE(scale);
    const auto values = solver.extend(vertices, std::vector<double>{scale, 2 * scale});
    const auto vectors = solver.transport(0, scale * Vec(0.3, 0.5, 0.7));
    for (std::size_t v = 0; v < values.size(); ++v) {
      CHECK(values[v] / scale == gelight::test::approx(extended[v]).epsilon(1e-12));
      // (Opposite the source, ways from all sides cancel.)
      if ((at(sphere, v) + at(sphere, 0)).norm() < 1e-12) continue;
      CHECK((vectors[v] / scale - carried[v]).norm() < 1e-12);
    }
  }
  CHECK_THROWS_AS((void)solver.extend(std::vector<Index>{3, 3}, std::vector<double>{1e308, 1e308}),
                  InvalidInput);
  const VectorHeatSolver<float> single(sphere);
  for (const float x : single.extend(vertices, std::vector<float>{1e38f, 2e38f})) {
    CHECK(x >= 1e38f);
    CHECK(x <= 2e38f);
  }
}

TEST_CASE("parts out of reach are zero, infinite or not a number, as documented") {
  const std::vector<Mesh<double>> parts{icosphere<double>(1), grid<double>(2, 2)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({9, 9, 9});
  const VectorHeatSolver solver(mesh);
  const auto carried = solver.transport(0, solver.tangent_basis(0)[0]);
  const auto radial = solver.radial(0);
  const auto map = solver.log_map(0);
  const std::vector<Index> from{0};
  const std::vector<double> value{1};
  const auto extended = solver.extend(from, value);
  for (std::size_t v = 0; v < carried.size(); ++v) {
    const bool reached = v < 42;
    CHECK(carried[v].norm() == gelight::test::approx(reached ? 1 : 0));
    CHECK(radial[v].norm() == gelight::test::approx(reached && v != 0 ? 1 : 0));
    CHECK(std::isfinite(map[v].norm()) == reached);
    CHECK(std::isnan(extended[v]) != reached);
  }
  CHECK_THROWS_AS((void)solver.radial(static_cast<Index>(mesh.positions.size()) - 1), InvalidInput);
}

TEST_CASE("a strip longer than heat reaches in doubles still carries vectors") {
  const VectorHeatSolver solver(grid<double>(4000, 1, 4000, 1));
  for (const auto& v : solver.transport(0, Vec(-1, 2, 0))) CHECK((v - Vec(-1, 2, 0)).norm() < 1e-9);
}

TEST_CASE("scale leaves directions alone") {
  const auto mesh = icosphere<double>(3);
  const auto expected = VectorHeatSolver(mesh).radial(0);
  for (const double s : {1e-20, 1e6}) {
    auto scaled = mesh;
    for (auto& p : scaled.positions) p = {s * p[0], s * p[1], s * p[2]};
    const auto radial = VectorHeatSolver(scaled).radial(0);
    for (std::size_t v = 0; v < radial.size(); ++v) {
      if ((at(mesh, v) + at(mesh, 0)).norm() < 1e-9) continue;  // radial from all sides
      CHECK((radial[v] - expected[v]).norm() < 1e-9);
    }
  }
}

TEST_CASE("bad input is refused by name") {
  auto mesh = icosphere<double>(1);
  const VectorHeatSolver solver(mesh);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto basis = solver.tangent_basis(0);
  CHECK_THROWS_AS((void)solver.transport(0, Vec(0, 0, 0)), InvalidInput);
  CHECK_THROWS_AS((void)solver.transport(0, basis[0].cross(basis[1])), InvalidInput);
  CHECK_THROWS_AS((void)solver.transport(0, Vec(nan, 0, 0)), InvalidInput);
  CHECK_THROWS_AS((void)solver.transport(42, basis[0]), InvalidInput);
  CHECK_THROWS_AS((void)solver.transport(std::vector<VectorSource<double>>{}), InvalidInput);
  for (const double time : {0.0, -1.0, nan, 1e308}) {
    CHECK_THROWS_AS((VectorHeatSolver(mesh, {.time_factor = time})), InvalidInput);
  }
  CHECK_THROWS_AS((void)solver.log_map(-1), InvalidInput);
  // Each is as long as a double may be, together they are longer.
  const Vec longest = 1e308 * basis[0];
  const VectorSource<double> one{vertex_point<double>(0), longest};
  CHECK((solver.transport(std::vector{one})[0] - longest).norm() < 1e294);
  CHECK_THROWS_WITH_AS((void)solver.transport(std::vector{one, one}),
                       "with that of source 1, the vectors' lengths at vertex 0 sum to inf",
                       InvalidInput);
  const std::vector<Index> vertex{0};
  CHECK_THROWS_AS((void)solver.extend(vertex, std::vector<double>{}), InvalidInput);
  CHECK_THROWS_AS((void)solver.extend(vertex, std::vector<double>{nan}), InvalidInput);
  std::swap(mesh.faces[3][0], mesh.faces[3][1]);
  CHECK_THROWS_AS(VectorHeatSolver{mesh}, InvalidInput);
}

namespace {

// A flat square whose faces lean: each vertex is joined to one some columns on in the next row.
Mesh<double> leaning_sheet(Index n, Index lean) {
  Mesh<double> mesh;
  mesh.positions = grid<double>(n, n).positions;
  for (Index j = 0; j < n; ++j) {
    const Index low = j * (n + 1), high = low + n + 1;
    for (Index i = 0; i < lean; ++i) {
      mesh.faces.push_back({low, high + i + 1, high + i});
      mesh.faces.push_back({low + n - lean + i, low + n - lean + i + 1, high + n});
    }
    for (Index i = 0; i < n - lean; ++i) {
      mesh.faces.push_back({low + i, low + i + 1, high + i + lean + 1});
      mesh.faces.push_back({low + i, high + i + lean + 1, high + i + lean});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("on the intrinsic Delaunay triangulation faces that lean do no harm") {
  const Index n = 40;
  const auto mesh = leaning_sheet(n, 6);
  const Index source = n / 2 * (n + 1) + n / 2;
  const Vec s = at(mesh, static_cast<std::size_t>(source));
  std::array<Worst, 2> radial, radius;
  for (const std::size_t k : {0U, 1U}) {
    // Which is the default.
    const VectorHeatSolver solver(
        mesh, k == 1 ? VectorHeatOptions{} : VectorHeatOptions{.intrinsic_delaunay = false});
    const auto away = solver.radial(source);
    const auto map = solver.log_map(source);
    for (std::size_t v = 0; v < away.size(); ++v) {
      const Vec way = at(mesh, v) - s;
      if (way.norm() == 0) continue;
      radial[k].add(angle_between(way, away[v]) / degree);
      radius[k].add(std::abs(map[v].norm() / way.norm() - 1));
    }
    MESSAGE(std::string(k == 0 ? "own edges" : "Delaunay")
            << ": radial " << radial[k].mean << " degrees off (mean), " << radial[k].max
            << " at most; radius " << 100 * radius[k].mean << " %, " << 100 * radius[k].max
            << " %");
  }
  CHECK(radial[1].mean < 2);
  CHECK(radial[1].mean < 0.5 * radial[0].mean);
  CHECK(radius[1].mean < 0.03);
}

TEST_CASE("on a sound mesh, Delaunay already, the option changes rounding alone") {
  const auto mesh = icosphere<double>(3);
  const VectorHeatSolver own(mesh, {.intrinsic_delaunay = false}), flipped(mesh);
  const auto basis = own.tangent_basis(9);
  const auto a = own.transport(9, basis[0]), b = flipped.transport(9, basis[0]);
  for (std::size_t v = 0; v < a.size(); ++v) {
    if ((at(mesh, v) + at(mesh, 9)).norm() > 1e-9) CHECK((a[v] - b[v]).norm() < 1e-9);
  }
}

TEST_CASE("in a flat sheet whose edges are all flipped a vector stays what it is") {
  // Sheared and stretched, so that the intrinsic Delaunay triangulation has other edges.
  auto mesh = grid<double>(14, 9, 1.0, 1.0);
  for (auto& p : mesh.positions) p = {p[0] + 2.7 * p[1], 0.3 * p[1], 0};
  const VectorHeatSolver solver(mesh, {.intrinsic_delaunay = true});
  for (const Vec& v : {Vec(1, 2, 0), Vec(-1, 2, 0), Vec(-3, -0.1, 0), Vec(0, -5, 0)}) {
    for (const auto& point : {vertex_point<double>(50), edge_point<double>(50, 51, 0.3),
                              face_point<double>(77, {0.2, 0.5, 0.3})}) {
      const std::vector<VectorSource<double>> sources{{point, v}};
      for (const auto& carried : solver.transport(sources)) CHECK((carried - v).norm() < 1e-10);
    }
  }
}

TEST_CASE("in a flat sheet of thin triangles no vector is reversed where heat is negative") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-0.03, 0.03);
  const Vec up(0, 1, 0);
  for (const double width : {1.0, 0.1, 0.02, 0.005}) {
    auto mesh = grid<double>(12, 9, 1.3, 1.0);
    for (auto& p : mesh.positions) {
      if (p[0] > 1e-9 && p[0] < 1.3 - 1e-9) p[0] += off(random);
      if (p[1] > 1e-9 && p[1] < 1 - 1e-9) p[1] += off(random);
      p[0] *= width;
    }
    for (const bool is_delaunay : {true, false}) {
      CAPTURE(width);
      CAPTURE(is_delaunay);
      const VectorHeatSolver solver(mesh, {.intrinsic_delaunay = is_delaunay});
      for (const auto& sources :
           {std::vector<VectorSource<double>>{{vertex_point<double>(64), up}},
            std::vector<VectorSource<double>>{{vertex_point<double>(0), up}},
            std::vector<VectorSource<double>>{{vertex_point<double>(40), up},
                                              {edge_point<double>(92, 93, 0.3), up}}}) {
        for (const auto& carried : solver.transport(sources)) CHECK((carried - up).norm() < 1e-7);
      }
    }
  }
}

TEST_CASE("a heat solver's matrices are shared, and the answer is the same to the last bit") {
  const auto mesh = torus(2.0, 0.7, 30, 14);
  for (const bool intrinsic : {false, true}) {
    const HeatSolver heat(mesh, {.time_factor = 2, .intrinsic_delaunay = intrinsic});
    const VectorHeatSolver shared(heat);
    const VectorHeatSolver own(mesh, {.time_factor = 2, .intrinsic_delaunay = intrinsic});
    const auto x = own.tangent_basis(5)[0];
    CHECK(shared.transport(5, x) == own.transport(5, x));
    CHECK(shared.log_map(5) == own.log_map(5));
    const std::vector<Index> at{3, 200};
    const std::vector<double> values{1, -2};
    CHECK(shared.extend(at, values) == own.extend(at, values));
  }
}

TEST_CASE("solve gives the same vectors and coordinates, and tells good ones from bad") {
  const auto sphere = icosphere<double>(4);
  auto sheet = grid<double>(30, 30, 30.0, 30.0);
  for (auto& p : sheet.positions) p[0] += 4 * p[1];
  const VectorHeatSolver on_sphere(sphere), on_sheet(sheet),
      on_thin(sheet, {.intrinsic_delaunay = false});
  for (const Index source : {12, 300, 555}) {
    const auto x = on_sphere.tangent_basis(source)[0];
    const auto carried = on_sphere.solve(source, x);
    CHECK(carried.vectors == on_sphere.transport(source, x));
    CHECK(carried.is_reliable);
    const auto map = on_sphere.solve_log_map(source);
    CHECK(map.coordinates == on_sphere.log_map(source));
    CHECK(map.is_reliable);
    // A flat sheet, where the truth is the difference of positions.
    for (const auto* solver : {&on_sheet, &on_thin}) {
      const auto result = solver->solve_log_map(source);
      const auto basis = solver->tangent_basis(source);
      double mean = 0;
      for (std::size_t v = 0; v < sheet.positions.size(); ++v) {
        const Vec truth = at(sheet, v) - at(sheet, static_cast<std::size_t>(source));
        const Vec found = result.coordinates[v][0] * basis[0] + result.coordinates[v][1] * basis[1];
        if (truth.norm() > 0) mean += (found - truth).norm() / truth.norm();
      }
      mean /= static_cast<double>(sheet.positions.size() - 1);
      MESSAGE("mean " << mean << ", said " << result.error);
      if (mean > 0.1) CHECK_FALSE(result.is_reliable);
      if (solver == &on_thin) CHECK(mean > 0.1);
    }
  }
}

TEST_CASE("directions from a border and beside one come nearer as a sheet is refined") {
  // In degrees, the mean over the vertices of a flat sheet.
  const auto off = [](Index cells, Index column, Index row) {
    const VectorHeatSolver solver(grid<double>(cells, cells, 1.0, 1.0));
    const Index source = row * (cells + 1) + column;
    const auto found = solver.radial(source);
    const Surface<double>& surface = solver.surface();
    double sum = 0;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      if (v == source) continue;
      const Vec3<double> way = surface.position(v) - surface.position(source);
      const auto& direction = found[static_cast<std::size_t>(v)];
      CHECK(direction.norm() == gelight::test::approx(1));
      sum += std::acos(std::clamp(direction.dot(way) / way.norm(), -1.0, 1.0));
    }
    return sum / (surface.vertex_count() - 1) * 180 / std::numbers::pi;
  };
  for (const auto& [column, row] : {std::array{0, 8}, {0, 0}, {16, 0}, {1, 8}}) {
    const double coarse = off(16, column, row);
    const double fine = off(32, column == 1 ? 1 : 2 * column, 2 * row);
    CHECK(coarse < 8);
    CHECK(fine < 0.8 * coarse);
  }
}

TEST_CASE("a cancelled query leaves the solver as it was") {
  const auto mesh = icosphere<double>(3);
  int left = 1 << 20;
  double told = 0;
  const CancelHook hook([&](double done) {
    CHECK(done >= told);
    told = done;
    return left-- == 0;
  });
  const VectorHeatSolver solver(mesh, {.cancelled = hook});
  const auto expected = VectorHeatSolver(mesh).log_map(7);
  for (const int asks : {0, 1, 5, 20}) {
    left = asks;
    told = 0;
    CHECK_THROWS_AS((void)solver.log_map(7), Cancelled);
  }
  left = 1 << 20;
  told = 0;
  CHECK(solver.log_map(7) == expected);
  left = 0;
  told = 0;
  CHECK_THROWS_AS(VectorHeatSolver(mesh, {.cancelled = hook}), Cancelled);
}
