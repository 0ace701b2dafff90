#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../support/parted_file.hpp"
#include "samples.hpp"

// How samples lie in the file: a dataset of each kind of thing, a row a sample.

/// The columns of a scene; each name stands for what `put_sample` puts there.
[[nodiscard]] inline std::vector<Column> columns_of(const Scene& scene) {
  using hdf5::Number;
  const auto width = static_cast<hsize_t>(scene.width), height = static_cast<hsize_t>(scene.height);
  const auto markers =
      static_cast<hsize_t>(scene.marker_columns) * static_cast<hsize_t>(scene.marker_rows);
  std::vector<Column> columns{{"sensor", Number::i32},     {"object", Number::i32},
                              {"press", Number::f64, {4}}, {"place", Number::f64, {6}},
                              {"light", Number::f64, {9}}, {"camera", Number::f64, {4}}};
  const auto add = [&](bool is_stored, Column column) {
    if (is_stored) columns.push_back(std::move(column));
  };
  const Stored& store = scene.store;
  // (Planes of colour take half the time and the space of colours side by side.)
  add(store.image, {"image", Number::u8, {height, width, 3}, true, 3});
  add(store.mask, {"mask", Number::u8, {height, width}, true});
  add(store.depth, {"depth", Number::f32, {height, width}, true});
  add(store.normals, {"normals", Number::f32, {height, width, 3}, true, 3});
  add(store.force, {"force", Number::f32, {3}});
  add(store.markers, {"markers", Number::f32, {markers, 2}});
  add(store.pose, {"pose", Number::f64, {3, 4}});
  add(store.seed, {"seed", Number::u64, {2}});
  return columns;
}

template <class P>
[[nodiscard]] auto numbers_of(const Image<P>& image) {
  using T = typename P::value_type;
  return std::span<const T>(image.pixels().data()->data(), 3 * image.pixels().size());
}
[[nodiscard]] inline std::span<const float> numbers_of(const Image<Vec3<float>>& image) {
  return {image.pixels().data()->data(), 3 * image.pixels().size()};
}

/// Puts a sample into a row of a part.
inline void put_sample(Part& part, const std::vector<Column>& columns, std::size_t row,
                       const Sample& sample) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto put = [&](auto numbers) { part.put(c, row, numbers); };
    const std::string& name = columns[c].name;
    if (name == "sensor") put(std::span(&sample.sensor, 1));
    if (name == "object") put(std::span(&sample.object, 1));
    if (name == "press") put(std::span<const double>(sample.press));
    if (name == "place") put(std::span<const double>(sample.place));
    if (name == "light") put(std::span<const double>(sample.light));
    if (name == "camera") put(std::span<const double>(sample.camera));
    if (name == "image") put(numbers_of(sample.image));
    if (name == "mask") put(std::span<const std::uint8_t>(sample.mask.pixels()));
    if (name == "depth") put(std::span<const float>(sample.depth.pixels()));
    if (name == "normals") put(numbers_of(sample.normals));
    if (name == "force") put(std::span<const float>(sample.force));
    if (name == "markers") put(std::span<const float>(sample.markers));
    if (name == "pose") put(std::span<const double>(sample.pose));
    if (name == "seed") put(std::span<const std::uint64_t>(sample.seed));
  }
}

/// What the file tells of itself besides.
[[nodiscard]] inline std::vector<std::pair<std::string, std::string>> notes_of(const Scene& scene) {
  const auto lines = [](const auto& ranges) {
    std::string text;
    for (const auto& range : ranges) text += range.name + "\n";
    text.pop_back();
    return text;
  };
  return {
      {"description", scene.text},
      {"sensors", lines(scene.sensors)},
      {"objects", lines(scene.objects)},
      {"press", "depth [m]\nshift along x [m]\nshift along y [m]\nelastic modulus [Pa]"},
      {"place", "column [pixel]\nrow [pixel]\nsize\nspin [rad]\nlean [rad]\nway of the lean [rad]"},
      {"light",
       "brightness of LED 1\nof LED 2\nof LED 3\nof LED 4\nambient\ndiffuse\nspecular\n"
       "shininess\nsmoothing [pixel]"},
      {"camera", "fx [pixel]\nfy [pixel]\ncx [pixel]\ncy [pixel]"}};
}
