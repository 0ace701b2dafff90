#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "draws.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

// What a dataset shall hold, as scene.json describes it. Metres and radians.

/// A kind of sensor, and how those that are built of it differ.
struct SensorRange {
  std::string name;                ///< of the model and its light
  std::string model = "geltip";    ///< or gelsight_mini, digit, sts
  std::string light = "geodesic";  ///< or linear, plane, transport
  double edge = 0.001;             ///< of the membrane's mesh
  Distribution brightness, ambient, diffuse, specular, shininess, smoothing;
};

/// A thing to press.
struct ObjectRange {
  std::string name;
  gelight::Mesh<float> mesh;  ///< touches at the origin first, its body towards +z
  Distribution size;          ///< by what it is multiplied
};

/// What is stored of each sample.
struct Stored {
  bool image = false, mask = false, depth = false, normals = false, force = false, markers = false,
       pose = false, seed = false;
};

struct Scene {
  std::uint64_t seed = 0, samples = 0;
  std::uint64_t part = 128;          ///< samples a file
  std::uint64_t sensor_every = 256;  ///< samples after which another sensor is built
  gelight::Index width = 320, height = 240;
  Stored store;
  std::vector<SensorRange> sensors;
  std::vector<ObjectRange> objects;
  Distribution column, row;  ///< where it is pressed, as shares of the image
  Distribution depth;        ///< how deep its first point comes
  Distribution spin, lean;   ///< about the membrane's normal, and away from it
  Distribution shift;        ///< how far it is then dragged, along x and y
  Distribution modulus;      ///< of the gel, Pa
  double gel_thickness = 0.004;
  int marker_columns = 9, marker_rows = 7;
  std::string text;         ///< the description without what does not matter
  std::string sample_text;  ///< and without how many samples: of what the first ones depend on
};

/// Reads a description. Throws InvalidInput that names file, key and value for what is missing,
/// misspelt or out of range, and for meshes that are not there.
[[nodiscard]] Scene read_scene(const std::string& path);
