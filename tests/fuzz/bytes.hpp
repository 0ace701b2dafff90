#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "gelight/views/mesh_view.hpp"

namespace gelight::fuzz {

/// What the fuzzer gives, read as numbers; zeros when it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  template <class T>
  [[nodiscard]] T take() {
    T value{};
    const std::size_t count = std::min(sizeof(T), size_);
    std::memcpy(&value, data_, count);
    data_ += count;
    size_ -= count;
    return value;
  }
  /// A number in [0, count).
  [[nodiscard]] Index below(Index count) { return take<std::uint8_t>() % count; }
  [[nodiscard]] bool empty() const { return size_ == 0; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

/// Ends the run, so that the fuzzer keeps the input.
inline void expect(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what.c_str());
  std::abort();
}

/// A mesh of a few vertices and faces: positions on a coarse lattice, of any size, or any bit
/// patterns at all; faces of any indices, mostly in range.
[[nodiscard]] inline Mesh<double> take_mesh(Bytes& bytes, Index most_vertices, Index most_faces) {
  Mesh<double> mesh;
  const Index vertices = bytes.below(most_vertices) + 1, faces = bytes.below(most_faces) + 1;
  const auto kind = bytes.take<std::uint8_t>() % 4;
  const double scale = kind == 1 ? std::ldexp(1.0, bytes.take<std::int8_t>()) : 1;
  const auto coordinate = [&]() -> double {
    if (kind == 3) return bytes.take<double>();
    if (kind == 2) return double{bytes.take<float>()};
    return scale * bytes.take<std::int8_t>() / 16;
  };
  for (Index v = 0; v < vertices; ++v) {
    const double x = coordinate(), y = coordinate(), z = coordinate();
    mesh.positions.push_back({x, y, z});
  }
  const auto index = [&]() -> Index {
    const auto raw = bytes.take<std::int8_t>();
    return raw > -100 ? (raw + 100) % vertices : raw;
  };
  for (Index f = 0; f < faces && !bytes.empty(); ++f) {
    const Index a = index(), b = index(), c = index();
    mesh.faces.push_back({a, b, c});
  }
  return mesh;
}

}  // namespace gelight::fuzz
