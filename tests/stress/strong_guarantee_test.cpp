#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/noise.hpp"
#include "gelight/sensor/see_through.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/transport/vector_heat.hpp"

// What writes into its caller's memory leaves it as it was when it throws: whether the input was
// bad, or memory ran out, at whichever allocation. And whoever ran out of memory answers as before
// when there is some again: no exception gets lost, none ends the program (no function here is
// declared noexcept; destructors and moves are), and no workspace is left half done.

namespace {

// How many allocations succeed before memory runs out; negative for never.
std::atomic<long> allocations_left = -1;
std::atomic<std::size_t> bytes_taken = 0;

void count(std::size_t size) {
  bytes_taken += size;
  if (allocations_left < 0) return;
  if (allocations_left == 0) throw std::bad_alloc();
  --allocations_left;
}

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  count(size);
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  count(size);
  const auto step = static_cast<std::size_t>(alignment);
  if (void* const memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocations_left == 0 ? nullptr : std::malloc(size);
}
// Not inlined, or g++ 12 takes their free for one without a malloc.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace {

using namespace gelight;
using Act = std::function<void()>;

/// A function that writes into its caller's memory, and what it is to be given.
struct Operation {
  std::string name;
  std::function<Act()> prepare;  ///< fills the memory; a call that succeeds, of a new solver
  std::function<std::string()> contents;  ///< of the memory
  std::vector<Act> refused{};             ///< calls that are refused
  bool works_in_memory = false;           ///< and so loses what is there when memory runs out
};

template <class T>
std::string bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Whether `act` runs out of memory after so many allocations.
bool runs_out(const Act& act, long allocations) {
  allocations_left = allocations;
  bool failed = false;
  try {
    act();
  } catch (const std::bad_alloc&) {
    failed = true;
  }
  allocations_left = -1;
  return failed;
}

/// Each of the first dozens, then in steps that grow.
long next(long allocations) { return allocations + 1 + allocations / 16; }

void check_untouched(const Operation& operation) {
  CAPTURE(operation.name);
  Act act = operation.prepare();
  const std::string before = operation.contents();
  for (std::size_t i = 0; i < operation.refused.size(); ++i) {
    CAPTURE(i);
    CHECK_THROWS_AS(operation.refused[i](), InvalidInput);
    CHECK(operation.contents() == before);
  }
  int places = 0;
  for (long allocations = 0; runs_out(act, allocations); allocations = next(allocations)) {
    CAPTURE(allocations);
    if (!operation.works_in_memory) REQUIRE(operation.contents() == before);
    act = operation.prepare();
    ++places;
  }
  const std::string expected = operation.contents();
  CHECK(expected != before);
  MESSAGE(operation.name, ": ", operation.refused.size(), " refusals, out of memory in ", places,
          " places");
  // The same solver, out of memory again and again before it has enough.
  act = operation.prepare();
  for (long allocations = 0; runs_out(act, allocations); allocations = next(allocations)) {
  }
  CHECK(operation.contents() == expected);
}

// --- distances -----------------------------------------------------------------------------------

template <class Solver, class T>
Operation distances(const std::string& name) {
  const auto mesh = icosphere<T>(1);
  const auto out = std::make_shared<std::vector<T>>(mesh.positions.size());
  const auto solver = std::make_shared<Solver>(mesh);
  const auto from = [=](const Source<T>& source) -> Act {
    return [=] { solver->distance_into(*out, std::span<const Source<T>>(&source, 1)); };
  };
  const T nan = std::numeric_limits<T>::quiet_NaN(), half = T(0.5);
  const auto prepare = [=]() -> Act {
    std::fill(out->begin(), out->end(), T(-7));
    const auto fresh = std::make_shared<Solver>(mesh);
    return [=] { fresh->distance_into(*out, Index{3}); };
  };
  return {name,
          prepare,
          [=] { return bytes(*out); },
          {[=] { solver->distance_into(*out, Index{42}); },
           [=] { solver->distance_into(*out, Index{-1}); },
           [=] { solver->distance_into(*out, std::span<const Index>()); },
           [=] { solver->distance_into(*out, std::span<const Source<T>>()); },
           [=] { solver->distance_into(std::span(*out).first(41), Index{0}); },
           from({vertex_point<T>(99), 0}), from({vertex_point<T>(0), nan}),
           from({face_point<T>(0, {half, half, half}), 0}), from({edge_point<T>(0, 0, half), 0})}};
}

// --- images --------------------------------------------------------------------------------------

constexpr Index width = 40, height = 24;

template <class T>
Camera<T> camera() {
  return {T(60), T(60), T(19.5), T(11.5), width, height};
}
template <class T>
std::vector<Light<T>> lights() {
  return {{Image<Vec3<T>>(width, height, Vec3<T>(1, 0, T(0.2)).normalized()), {1, T(0.5), 0}}};
}
template <class T>
Image<T> rest() {
  return Image<T>(width, height, T(0.03));
}
template <class T>
Image<T> pressed() {
  Image<T> depth = rest<T>();
  for (Index x = 10; x < 30; ++x) depth(x, 12) = T(0.0285);
  return depth;
}
template <class T>
Image<T> too_small() {
  return Image<T>(width - 1, height, T(0.03));
}

/// `render(renderer, out)` is to render `pressed`; `refused(renderer, out)` are to be refused.
template <class Renderer, class T>
Operation rendering(const std::string& name,
                    const std::function<void(const Renderer&, ImageView<Rgb8>)>& render,
                    const std::vector<std::function<void(const Renderer&, ImageView<Rgb8>)>>& bad) {
  const auto out = std::make_shared<Image<Rgb8>>(width, height);
  const auto make = [] { return std::make_shared<Renderer>(camera<T>(), rest<T>(), lights<T>()); };
  const auto prepare = [=]() -> Act {
    for (Rgb8& pixel : out->pixels()) pixel = {1, 2, 3};
    const auto renderer = make();
    return [=] { render(*renderer, *out); };
  };
  Operation operation{name, prepare, [=] { return bytes(out->pixels()); }};
  const auto renderer = make();
  for (const auto& act : bad) operation.refused.push_back([=] { act(*renderer, *out); });
  return operation;
}

/// The bytes of an image's memory seen as depths.
template <class T>
ImageView<const T> as_depths(ImageView<Rgb8> image) {
  // Rows that overlap one another, so that the memory is large enough.
  return ImageView<const T>::from_bytes(reinterpret_cast<const T*>(image.data()), width, height, 0,
                                        0);
}

template <class T>
std::string contents(const SpringContact<T>& contact) {
  const std::vector<double> numbers{contact.displacement, contact.tilt[0], contact.tilt[1],
                                    contact.force, contact.residual_force};
  return bytes(numbers) + bytes(contact.indentation.pixels()) + bytes(contact.touching.pixels());
}

}  // namespace

TEST_CASE_TEMPLATE("distances into the caller's memory", T, float, double) {
  check_untouched(distances<DijkstraSolver<T>, T>("Dijkstra"));
  check_untouched(distances<FastMarchingSolver<T>, T>("fast marching"));
  check_untouched(distances<VirtualSourceSolver<T>, T>("virtual source"));
  check_untouched(distances<ExactSolver<T>, T>("exact"));
  check_untouched(distances<HeatSolver<T>, T>("heat"));
}

TEST_CASE_TEMPLATE("images into the caller's memory", T, float, double) {
  using Tactile = TactileRenderer<T>;
  check_untouched(rendering<Tactile, T>(
      "tactile image",
      [](const Tactile& r, ImageView<Rgb8> out) { r.render_into(out, pressed<T>()); },
      {[](const Tactile& r, ImageView<Rgb8> out) { r.render_into(out, too_small<T>()); },
       [](const Tactile& r, ImageView<Rgb8> out) { r.render_into(out.transposed(), rest<T>()); },
       [](const Tactile& r, ImageView<Rgb8> out) { r.render_into(out, as_depths<T>(out)); }}));
  using Through = SeeThroughRenderer<T>;
  check_untouched(rendering<Through, T>(
      "image through the skin",
      [](const Through& r, ImageView<Rgb8> out) { r.render_into(out, pressed<T>()); },
      {[](const Through& r, ImageView<Rgb8> out) { r.render_into(out, too_small<T>()); },
       [](const Through& r, ImageView<Rgb8> out) { r.render_into(out.transposed(), rest<T>()); },
       [](const Through& r, ImageView<Rgb8> out) { r.render_into(out, rest<T>(), too_small<T>()); },
       [](const Through& r, ImageView<Rgb8> out) { r.render_into(out, rest<T>(), out); },
       [](const Through& r, ImageView<Rgb8> out) {
         r.render_into(out, rest<T>(), rest<T>(), {-1, 0});
       },
       [](const Through& r, ImageView<Rgb8> out) { r.render_into(out, as_depths<T>(out)); }}));
}

TEST_CASE_TEMPLATE("the next frame of a sequence", T, float, double) {
  const auto frame = std::make_shared<TactileFrame<T>>();
  const auto make = [] {
    return std::make_shared<TactileRenderer<T>>(camera<T>(), rest<T>(), lights<T>());
  };
  const auto prepare = [=]() -> Act {
    const auto renderer = make();
    *frame = renderer->rest_frame();
    return [=] { renderer->render_next_into(*frame, pressed<T>()); };
  };
  const auto renderer = make();
  check_untouched({"next frame",
                   prepare,
                   [=] { return bytes(frame->depth.pixels()) + bytes(frame->image.pixels()); },
                   {[=] { renderer->render_next_into(*frame, too_small<T>()); },
                    [=] { renderer->render_next_into(*frame, as_depths<T>(frame->image)); }}});
}

TEST_CASE_TEMPLATE("a contact whose images are used again", T, float, double) {
  for (const double tension : {0.0, 50.0}) {
    const SpringBed<T> bed(camera<T>(), T(0.03), {.tension = tension});
    const auto contact = std::make_shared<SpringContact<T>>();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto prepare = [=]() -> Act {
      *contact = bed.press(rest<T>(), 0.1);
      return [=] { bed.press_into(*contact, pressed<T>(), 1); };
    };
    check_untouched({"contact",
                     prepare,
                     [=] { return contents(*contact); },
                     {[=] { bed.press_into(*contact, too_small<T>(), 1); },
                      [=] { bed.press_into(*contact, pressed<T>(), nan); },
                      [=] {
                        bed.press_tilting_into(*contact, pressed<T>(), 1, {nan, 0});
                      },
                      [=] {
                        bed.press_tilting_into(*contact, too_small<T>(), 1, {0, 0});
                      }},
                     tension > 0});
  }
}

TEST_CASE("noise added to an image") {
  const auto image = std::make_shared<Image<Rgb8>>(9, 5);
  const auto prepare = [=]() -> Act {
    *image = Image<Rgb8>(9, 5, {100, 100, 100});
    return [=] { add_noise(*image, 3, 1); };
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  check_untouched({"noise",
                   prepare,
                   [=] { return bytes(image->pixels()); },
                   {[=] { add_noise(*image, -1, 1); }, [=] { add_noise(*image, nan, 1); }}});
}

// Counted, since times depend on who else computes.
TEST_CASE("an exact solve asks whether to go on before it takes memory and every 256 vertices") {
  const auto mesh = icosphere<double>(4);
  const ExactSolver solver(mesh);
  int polls = 0;
  (void)solver.solve(Index{0}, {.cancelled = [&] {
                       ++polls;
                       return false;
                     }});
  CHECK(polls >= static_cast<int>(mesh.positions.size()) / 256 + 2);
  for (int last = 1; last <= polls; ++last) {
    int left = last;
    const ExactOptions<double> options{.cancelled = [&] { return --left == 0; }};
    CHECK_THROWS_AS((void)solver.solve(Index{0}, options), Cancelled);
    CHECK(left == 0);
  }
  const std::size_t before = bytes_taken;
  CHECK_THROWS_AS((void)solver.solve(Index{0}, {.cancelled = [] { return true; }}), Cancelled);
  CHECK(bytes_taken - before < 2 * mesh.positions.size());
  CHECK(solver.distance(Index{0}) == ExactSolver(mesh).distance(Index{0}));
}

// What gives its result back has no output to touch; it must end in std::bad_alloc, and lose
// nothing (the preset `sanitize` tells what it lost).
TEST_CASE("out of memory at any allocation") {
  const auto mesh = icosphere<double>(1);
  const ExactSolver solver(mesh);
  const auto field = solver.solve(Index{0}, {.keep_windows = true});
  const auto point = face_point<double>(7, {0.25, 0.25, 0.5});
  const VectorHeatSolver<double> vectors(mesh);
  const std::vector<std::pair<std::string, Act>> table{
      {"surface", [&] { const Surface<double> made(mesh); }},
      {"check", [&] { (void)gelight::check(mesh); }},
      {"repair", [&] { (void)repair(mesh, {.weld_distance = 0.1, .split_vertices = true}); }},
      {"exact solver", [&] { const ExactSolver made(mesh); }},
      {"exact field", [&] { (void)solver.solve(Index{0}, {.keep_windows = true}); }},
      {"exact path", [&] { (void)field.path(point); }},
      {"exact arrivals", [&] { (void)field.arrivals(point); }},
      {"heat solver", [&] { (void)HeatSolver<double>(mesh).distance(Index{0}); }},
      {"vector heat solver", [&] { const VectorHeatSolver<double> made(mesh); }},
      {"transport", [&] { (void)vectors.transport(0, Vec3<double>(1, 0, 0)); }},
      {"log map", [&] { (void)vectors.log_map(0); }},
      {"smoothing", [&] { (void)gaussian(pressed<float>(), 1.5, 5); }},
  };
  for (const auto& entry : table) {
    const std::string& name = entry.first;
    const Act& act = entry.second;
    CAPTURE(name);
    int places = 0;
    for (long allocations = 0; runs_out(act, allocations); allocations = next(allocations)) {
      ++places;
    }
    MESSAGE(name, ": out of memory in ", places, " places");
    CHECK(places > 0);
    CHECK_NOTHROW(act());
  }
}
