#pragma once

#include <doctest/doctest.h>

#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/image/filter.hpp"
#include "gelight/image/grey.hpp"
#include "gelight/io/image.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

// The GelTip authors' published data, where it is there.
namespace reference {

using namespace gelight;

inline std::string path(const std::string& file) {
  return (std::filesystem::path(GELIGHT_REFERENCE_DIR) / file).string();
}

inline bool is_absent() {
  if (std::filesystem::exists(path("geltip/depth/rest.npy"))) return false;
  MESSAGE("skipped: no reference data at " << GELIGHT_REFERENCE_DIR);
  return true;
}

inline Image<float> depth(const std::string& name) {
  return read_npy<float>(path("geltip/depth/" + name + ".npy"));
}

inline Image<std::uint8_t> background() {
  return grey(read_png(path("geltip/image/background.png")));
}

// An intermediate result for contact_2.
template <class P>
Image<P> stage(const std::string& name) {
  return read_npy<P>(path("geltip/stage/" + name + ".npy"));
}

template <class T>
Camera<T> camera() {
  return Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 2, 640, 480);
}

// A light field at the camera's size: blurred and resized, not made unit again.
template <class T>
Image<Vec3<T>> field(const std::string& method, int led) {
  const auto coarse = read_npy<Vec3<double>>(
      path("geltip/field/" + method + "_led" + std::to_string(led) + ".npy"));
  const auto fine = resize_bilinear(gaussian(coarse, 4.1, 12), 640, 480);
  Image<Vec3<T>> out(640, 480);
  for (Index y = 0; y < 480; ++y) {
    for (Index x = 0; x < 640; ++x) out(x, y) = fine(x, y).template cast<T>();
  }
  return out;
}

// Red, green and blue light from LED 1, 2 and 0.
template <class T>
std::vector<Light<T>> lights(const std::string& method) {
  return {{field<T>(method, 1), {1, 0, 0}},
          {field<T>(method, 2), {0, 1, 0}},
          {field<T>(method, 0), {0, 0, 1}}};
}

}  // namespace reference
