#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "figure.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"

// What a physics engine moves, as somebody beside it sees it, and pictures of many moments.

/// A rigid body; its pose is that in the world.
struct Body {
  gelight::Mesh<double> mesh;
  Colour colour;
  gelight::Pose pose = {};
};

/// The pose of what is fixed to a moved frame.
[[nodiscard]] inline gelight::Pose moved(const gelight::Pose& frame, const gelight::Pose& part) {
  return {frame.rotation * part.rotation, frame(part.translation)};
}

/// A pose seen from another: where the body is in the frame of that.
[[nodiscard]] inline gelight::Pose seen_from(const gelight::Pose& frame,
                                             const gelight::Pose& body) {
  const Eigen::Matrix3d back = frame.rotation.transpose();
  return {back * body.rotation, back * (body.translation - frame.translation)};
}

/// The pose of a camera that looks from one point at another, z upwards.
[[nodiscard]] inline gelight::Pose looking(const gelight::Vec3<double>& from,
                                           const gelight::Vec3<double>& at) {
  const gelight::Vec3<double> forward = (at - from).normalized();
  const gelight::Vec3<double> right = gelight::cross<double>(forward, {0, 0, 1}).normalized();
  Eigen::Matrix3d axes;
  axes << right, gelight::cross<double>(forward, right), forward;
  return {axes, from};
}

/// Bodies as a camera sees them: matt, lit from above its left shoulder, before white.
[[nodiscard]] inline gelight::Image<gelight::Rgb8> photograph(
    std::span<const Body> bodies, const gelight::Pose& eye, const gelight::Camera<float>& camera) {
  using gelight::Index;
  using gelight::Vec3;
  constexpr float nothing = std::numeric_limits<float>::infinity();
  const Vec3<double> light = Vec3<double>(0.5, 0.8, 0.6).normalized();  // the way it travels
  gelight::Image<gelight::Rgb8> image(camera.width, camera.height, {255, 255, 255});
  gelight::Image<float> nearest(camera.width, camera.height, nothing);
  for (const Body& body : bodies) {
    const gelight::Pose pose = seen_from(eye, body.pose);
    const auto moved = gelight::placed<double>(body.mesh, pose.rotation, pose.translation);
    const auto raster = gelight::rasterize<float>(moved, camera);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        if (!(raster.depth(x, y) < nearest(x, y))) continue;
        nearest(x, y) = raster.depth(x, y);
        const auto [a, b, c] = moved.faces[static_cast<std::size_t>(raster.face(x, y))];
        const auto at = [&](Index v) { return Vec3<double>(moved.position(v).data()); };
        Vec3<double> normal =
            gelight::cross<double>(at(b) - at(a), at(c) - at(a)).stableNormalized();
        if (normal.dot(at(a)) > 0) normal = -normal;  // towards the camera
        const double shade = 0.35 + 0.65 * std::max(0.0, -normal.dot(light));
        const auto level = [&](double share) {
          return static_cast<std::uint8_t>(255 * std::min(1.0, share * shade));
        };
        image(x, y) = {level(body.colour.red), level(body.colour.green), level(body.colour.blue)};
      }
    }
  }
  return image;
}

/// Two images beside each other, with words at the foot of the first.
[[nodiscard]] inline gelight::Image<gelight::Rgb8> side_by_side(
    const gelight::Image<gelight::Rgb8>& left, const gelight::Image<gelight::Rgb8>& right,
    const std::string& words) {
  Figure page(left.width() + right.width(), left.height());
  page.image(left, 0, 0);
  page.image(right, left.width(), 0);
  page.text_from(words, 0.03 * left.width(), 0.94 * left.height(), 0.07 * left.height());
  return page.pixels();
}

/// How many pixels of two images differ by more than some grey levels in a channel.
[[nodiscard]] inline std::ptrdiff_t changed_pixels(const gelight::Image<gelight::Rgb8>& image,
                                                   const gelight::Image<gelight::Rgb8>& before) {
  constexpr int levels = 8;
  std::ptrdiff_t count = 0;
  for (std::size_t i = 0; i < image.pixels().size(); ++i) {
    bool differs = false;
    for (std::size_t c = 0; c < 3; ++c) {
      differs |= std::abs(int{image.pixels()[i][c]} - int{before.pixels()[i][c]}) > levels;
    }
    count += differs ? 1 : 0;
  }
  return count;
}

/// A column of images under a name.
struct Column {
  std::string name;
  std::vector<gelight::Image<gelight::Rgb8>> images;
};

/// A contact sheet: images of one size in columns, the rows named at the left.
inline void save_sheet(const std::string& path, std::span<const Column> columns,
                       std::span<const char* const> rows) {
  const double cell = 256, gap = 6, margin = 34;
  const auto& first = columns[0].images[0];
  const double scale = cell / first.width(), high = scale * first.height();
  Figure figure(static_cast<int>(margin + static_cast<double>(columns.size()) * (cell + gap)),
                static_cast<int>(margin + static_cast<double>(rows.size()) * (high + gap)));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double x = margin + static_cast<double>(i) * (cell + gap);
    figure.text(columns[i].name, x + cell / 2, margin / 2, 16);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double y = margin + static_cast<double>(k) * (high + gap);
      figure.image(columns[i].images[k], x, y, scale);
      if (i == 0) figure.text(rows[k], margin / 2, y + high / 2, 16, true);
    }
  }
  figure.save(path);
}
