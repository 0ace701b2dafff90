#pragma once

#include <time.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "gelight/image/camera.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/views/image_view.hpp"
#include "scene.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Vec3;

// One sample after the other. Each depends on the scene's seed and its number alone.

/// What the time goes into, in seconds of a thread's processor.
enum class Stage { sensor, object, render, labels, compress, write, count };

class Stopwatch {
 public:
  using Times = std::array<double, static_cast<std::size_t>(Stage::count)>;

  /// Adds what has passed since the last call to a stage.
  void lap(Stage stage) {
    const double time = now();
    times_[static_cast<std::size_t>(stage)] += time - last_;
    last_ = time;
  }
  [[nodiscard]] const Times& times() const { return times_; }
  void restart() { last_ = now(); }

 private:
  static double now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double last_ = 0;
  Times times_{};
};

struct Sample {
  std::int32_t sensor = 0, object = 0;  ///< of the scene's
  Image<gelight::Rgb8> image;
  Image<std::uint8_t> mask;             ///< 1 where the object touches
  Image<float> depth;                   ///< of the membrane under contact, m; NaN: none
  Image<Vec3<float>> normals;           ///< of that, towards the camera; NaN: none
  std::array<float, 3> force{};         ///< of the object on the membrane, N
  std::vector<float> markers;           ///< how far along x and y, pixels, in turns; NaN: not seen
  std::array<double, 12> pose{};        ///< 3 x 4, from the object to the camera
  std::array<std::uint64_t, 2> seed{};  ///< of the scene, and the sample's number
  std::array<double, 4> press{};        ///< depth, shift along x and y (m), the gel's modulus (Pa)
  /// Column and row (pixels), the object's size, its spin, its lean and the way of that (radians).
  std::array<double, 6> place{};
  /// Brightness of up to four LEDs (NaN: none), ambient, diffuse, specular, shininess, smoothing.
  std::array<double, 9> light{};
  std::array<double, 4> camera{};  ///< fx, fy, cx, cy (pixels)
};

struct LitSensor;    // a kind of sensor and its light; see sensors.hpp
struct BuiltSensor;  // one that was built of it

/// The kinds of sensors of a scene, lit: found once, for all threads.
class LitSensors {
 public:
  explicit LitSensors(const Scene& scene);
  ~LitSensors();
  [[nodiscard]] const std::vector<LitSensor>& kinds() const { return kinds_; }

 private:
  std::vector<LitSensor> kinds_;
};

/// Makes samples, for one thread. Those that follow each other share a sensor.
class Sampler {
 public:
  Sampler(const Scene& scene, const LitSensors& sensors);
  ~Sampler();
  Sampler(Sampler&&) noexcept;

  /// The sample of this number; it stays until the next call.
  [[nodiscard]] const Sample& sample(std::uint64_t number, Stopwatch& watch);

 private:
  void take_sensor(std::uint64_t number);
  /// Where on the membrane, and its normal out of the sensor; sets the sample's column and row.
  [[nodiscard]] std::pair<Vec3<double>, Vec3<double>> place(const Draws& draws,
                                                            const LitSensor& sensor);
  void place_object(const Draws& draws, const LitSensor& sensor);
  void take_near_part(const gelight::Mesh<float>& object, double height);
  void label(const LitSensor& sensor);
  void press_back(const LitSensor& sensor);
  void drag_markers(const LitSensor& sensor);

  const Scene& scene_;
  const std::vector<LitSensor>& kinds_;
  std::unique_ptr<BuiltSensor> built_;
  std::uint64_t number_ = 0;        // of that
  gelight::Mesh<float> near_part_;  // of the object: the rest cannot be seen
  std::vector<float> heights_;      // of the object's vertices above the first, along the normal
  std::vector<Index> numbers_;      // of the object's vertices in that part
  Image<float> object_depth_;
  gelight::RasterWorkspace raster_work_;
  Sample sample_;
};
