#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <new>
#include <vector>

#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

// Every byte that this program takes from the heap is counted.
namespace {

std::atomic<std::size_t> bytes_taken = 0;

}  // namespace

// (Not inlined, or g++ takes what is allocated here and freed there for a mistake.)
[[gnu::noinline]] void* operator new(std::size_t size) {
  bytes_taken += size;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  bytes_taken += size;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace gelight;

namespace {

template <class Renderer>
void check_frames(const Renderer& renderer) {
  const Image<float> rest(100, 80, 0.03f);
  Image<float> contact = rest, holed = rest, everywhere(100, 80, 0.02f);
  for (Index y = 30; y < 50; ++y) {
    for (Index x = 20; x < 90; x += 17) contact(x, y) = 0.025f;
    holed(y, y) = std::numeric_limits<float>::quiet_NaN();
  }
  Image<Rgb8> out(100, 80);
  auto frame = renderer.rest_frame();
  for (const auto* depth :
       std::initializer_list<const Image<float>*>{&rest, &contact, &holed, &everywhere, &contact}) {
    const std::size_t before = bytes_taken;
    renderer.render_into(out, *depth);
    renderer.render_next_into(frame, *depth);
    CHECK(bytes_taken - before == 0);
  }
}

}  // namespace

TEST_CASE("a frame after the first takes no memory, whatever it shows") {
  const Camera<float> camera{60, 60, 49.5, 39.5, 100, 80};
  const Image<float> rest(100, 80, 0.03f);
  const std::vector<Light<float>> lights{
      {Image<Vec3<float>>(100, 80, Vec3<float>(1, 0, 0)), {1, 0, 0}}};
  const std::array sigmas{3.0, 1.0};
  check_frames(TactileRenderer(camera, rest, lights));
  check_frames(
      TactileRenderer(camera, rest, PyramidMembrane<float>(sigmas), PhongLights<float>{lights}));
  check_frames(
      TactileRenderer(camera, rest, FlatGelSightMembrane<float>(), PhongLights<float>{lights}));
  check_frames(TactileRenderer(camera, rest, BulgingMembrane<float>(camera, 0.03f),
                               PhongLights<float>{lights}));
  check_frames(TactileRenderer(camera, rest,
                               ShadowedMembrane<float>(camera, GaussianMembrane<float>()),
                               PhongLights<float>{lights}));
}
