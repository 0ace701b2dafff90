#include "samples.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "gelight/membrane/elastic.hpp"
#include "gelight/membrane/markers.hpp"
#include "sensors.hpp"

namespace {

// Beyond this height above the camera an object is behind the membrane wherever it is seen: the
// membrane, the camera and all between lie below. (And a little more, for rounding.)
double reach_of(const gelight::Mesh<float>& membrane, const Vec3<double>& up) {
  const Vec3<float> way = up.cast<float>();
  float reach = 0;
  for (const auto& p : membrane.positions) {
    reach = std::max(reach, way.x() * p[0] + way.y() * p[1] + way.z() * p[2]);
  }
  return double{reach} + 1e-5;
}

// The membrane at rest between four pixels and its normal out of the sensor, if all of them see it.
std::optional<std::pair<Vec3<double>, Vec3<double>>> membrane_at(const LitSensor& sensor, double x,
                                                                 double y) {
  const auto& camera = sensor.preset.camera;
  const Index left = std::min(static_cast<Index>(x), camera.width - 2);
  const Index top = std::min(static_cast<Index>(y), camera.height - 2);
  Vec3<double> normal = Vec3<double>::Zero();
  double nearness = 0;  // 1 / depth, which is linear over the image of a plane
  for (const Index row : {top, top + 1}) {
    for (const Index column : {left, left + 1}) {
      if (sensor.normals(column, row).isZero()) return std::nullopt;
      const double share = (1 - std::abs(x - column)) * (1 - std::abs(y - row));
      nearness += share / double{sensor.rest.depth(column, row)};
      normal += share * sensor.normals(column, row).cast<double>();
    }
  }
  const auto point = camera.template cast<double>().unproject(x, y, 1 / nearness);
  return std::pair<Vec3<double>, Vec3<double>>(point, -normal.normalized());
}

// Where a place can come to, in pixels: one at least of each pair of neighbours that it can lie
// between.
std::vector<double> reach_of(const Distribution& share, Index size) {
  const auto at = [&](double of) { return std::clamp(of * size - 0.5, 0.0, size - 1.0); };
  std::vector<double> all;
  for (const double choice : share.choices) all.push_back(at(choice));
  if (!all.empty()) return all;
  all = {at(share.least()), at(share.most())};
  for (double pixel = std::ceil(all[0]); pixel < all[1]; ++pixel) all.push_back(pixel);
  return all;
}

// Refuses a sensor beside whose membrane all places lie.
void require_membrane(const Scene& scene, const LitSensor& sensor) {
  const auto columns = reach_of(scene.column, sensor.preset.camera.width);
  const auto rows = reach_of(scene.row, sensor.preset.camera.height);
  const bool is_there = std::any_of(rows.begin(), rows.end(), [&](double y) {
    return std::any_of(columns.begin(), columns.end(),
                       [&](double x) { return membrane_at(sensor, x, y).has_value(); });
  });
  gelight::detail::require(is_there,
                           "the scene's pose presses beside the membrane wherever it can");
}

}  // namespace

LitSensors::LitSensors(const Scene& scene) {
  for (const SensorRange& range : scene.sensors) {
    try {
      kinds_.push_back(lit_sensor(range, scene.width, scene.height));
      require_membrane(scene, kinds_.back());
    } catch (const gelight::InvalidInput& why) {
      gelight::detail::refuse({"the sensor \"", range.name, "\": ", why.what()});
    }
  }
}
LitSensors::~LitSensors() = default;

Sampler::Sampler(const Scene& scene, const LitSensors& sensors)
    : scene_(scene), kinds_(sensors.kinds()) {}
Sampler::~Sampler() = default;
Sampler::Sampler(Sampler&&) noexcept = default;

const Sample& Sampler::sample(std::uint64_t number, Stopwatch& watch) {
  watch.restart();
  take_sensor(number / scene_.sensor_every);
  watch.lap(Stage::sensor);
  const Draws draws(scene_.seed, Draws::Of::sample, number);
  const LitSensor& sensor = kinds_[built_->drawn.kind];
  sample_.seed = {scene_.seed, number};
  sample_.sensor = static_cast<std::int32_t>(built_->drawn.kind);
  sample_.press = {scene_.depth.draw(draws, Drawn::depth), scene_.shift.draw(draws, Drawn::shift_x),
                   scene_.shift.draw(draws, Drawn::shift_y),
                   scene_.modulus.draw(draws, Drawn::modulus)};
  sample_.light = light_of(built_->drawn);
  const auto& camera = sensor.preset.camera;
  sample_.camera = {camera.fx, camera.fy, camera.cx, camera.cy};
  place_object(draws, sensor);
  watch.lap(Stage::object);
  built_->renderer.render_into(sample_.image, object_depth_);
  watch.lap(Stage::render);
  label(sensor);
  watch.lap(Stage::labels);
  return sample_;
}

void Sampler::take_sensor(std::uint64_t number) {
  if (built_ && number_ == number) return;
  number_ = number;
  const DrawnSensor drawn = drawn_sensor(scene_, kinds_, number);
  if (built_ && built_->drawn == drawn) return;
  built_.reset();
  built_ = std::make_unique<BuiltSensor>(built_sensor(kinds_[drawn.kind], drawn));
  const auto& camera = built_->renderer.camera();
  if (object_depth_.width() == camera.width) return;
  object_depth_ = Image<float>(camera.width, camera.height);
  sample_.image = Image<gelight::Rgb8>(camera.width, camera.height);
  sample_.mask = Image<std::uint8_t>(camera.width, camera.height);
}

// Drawn anew where there is no membrane.
std::pair<Vec3<double>, Vec3<double>> Sampler::place(const Draws& draws, const LitSensor& sensor) {
  const auto& camera = sensor.preset.camera;
  for (std::uint32_t attempt = 0; attempt < Distribution::most_attempts; ++attempt) {
    const auto at = [&](const Distribution& share, Drawn what, Index size) {
      return std::clamp(share.draw(draws, what, attempt) * size - 0.5, 0.0, size - 1.0);
    };
    const double x = at(scene_.column, Drawn::column, camera.width);
    const double y = at(scene_.row, Drawn::row, camera.height);
    if (const auto found = membrane_at(sensor, x, y)) {
      sample_.place[0] = x;
      sample_.place[1] = y;
      return *found;
    }
  }
  gelight::detail::refuse({"the scene's pose presses beside the membrane of ",
                           scene_.sensors[built_->drawn.kind].name, " each of ",
                           Distribution::most_attempts, " times"});
}

void Sampler::place_object(const Draws& draws, const LitSensor& sensor) {
  const auto [point, out] = place(draws, sensor);
  const auto which = static_cast<std::size_t>(draws.uniforms(Drawn::object)[0] *
                                              static_cast<double>(scene_.objects.size()));
  const ObjectRange& object = scene_.objects[which];
  sample_.object = static_cast<std::int32_t>(which);
  const double spin = scene_.spin.draw(draws, Drawn::spin);
  const double lean = scene_.lean.draw(draws, Drawn::lean);
  const double way = 2 * std::numbers::pi * draws.uniforms(Drawn::lean_way)[0];
  const Vec3<double> side =
      (std::abs(out.x()) < 0.7 ? Vec3<double>::UnitX() : Vec3<double>::UnitY())
          .cross(out)
          .normalized();
  Eigen::Matrix3d frame;
  frame << side, out.cross(side), out;
  const auto about = [](double angle, const Vec3<double>& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  const Vec3<double> x = Vec3<double>::UnitX(), z = Vec3<double>::UnitZ();
  const double size = object.size.draw(draws, Drawn::size);
  const Eigen::Matrix3d turned =
      size * (frame * about(way, z) * about(lean, x) * about(spin - way, z));
  std::copy_n(std::array{size, spin, lean, way}.begin(), 4, sample_.place.begin() + 2);
  // Its first point comes to the place, as deep as it shall.
  const Vec3<float> up = (turned.transpose() * out).cast<float>();
  const auto& points = object.mesh.positions;
  heights_.clear();
  for (const auto& p : points) heights_.push_back(up.x() * p[0] + up.y() * p[1] + up.z() * p[2]);
  const auto lowest = std::min_element(heights_.begin(), heights_.end()) - heights_.begin();
  const auto& first = points[static_cast<std::size_t>(lowest)];
  const Vec3<double> touching(double{first[0]}, double{first[1]}, double{first[2]});
  const Vec3<double> moved = point - sample_.press[0] * out - turned * touching;
  for (Index r = 0; r < 3; ++r) {
    for (Index c = 0; c < 3; ++c) sample_.pose[static_cast<std::size_t>(4 * r + c)] = turned(r, c);
    sample_.pose[static_cast<std::size_t>(4 * r + 3)] = moved[r];
  }
  take_near_part(object.mesh, reach_of(sensor.preset.membrane, out) - out.dot(moved));
  object_depth_.pixels().assign(object_depth_.pixels().size(),
                                std::numeric_limits<float>::infinity());
  gelight::rasterize_into(object_depth_, near_part_, {turned, moved}, sensor.preset.camera,
                          &raster_work_);
}

// The faces that have a vertex below this height, and their vertices, in the object's order.
void Sampler::take_near_part(const gelight::Mesh<float>& object, double height) {
  near_part_.positions.clear();
  near_part_.faces.clear();
  numbers_.assign(object.positions.size(), -1);
  for (const auto& face : object.faces) {
    const bool is_near = std::any_of(face.begin(), face.end(), [&](Index v) {
      return heights_[static_cast<std::size_t>(v)] < height;
    });
    if (!is_near) continue;
    near_part_.faces.push_back(face);
    for (const Index v : face) numbers_[static_cast<std::size_t>(v)] = 0;
  }
  for (std::size_t v = 0; v < numbers_.size(); ++v) {
    if (numbers_[v] < 0) continue;
    numbers_[v] = static_cast<Index>(near_part_.positions.size());
    near_part_.positions.push_back(object.positions[v]);
  }
  for (auto& face : near_part_.faces) {
    for (Index& v : face) v = numbers_[static_cast<std::size_t>(v)];
  }
}

void Sampler::label(const LitSensor& sensor) {
  const Stored& store = scene_.store;
  const auto& camera = sensor.preset.camera;
  const float* const rest = sensor.rest.depth.pixels().data();
  const float* const seen = object_depth_.pixels().data();
  std::uint8_t* const mask = sample_.mask.pixels().data();
  for (std::size_t i = 0; i < object_depth_.pixels().size(); ++i) {
    mask[i] = static_cast<std::uint8_t>((seen[i] < rest[i]) &
                                        (rest[i] < std::numeric_limits<float>::infinity()));
  }
  if (store.depth || store.normals) {
    sample_.depth =
        gelight::elastic_depth(object_depth_, sensor.rest.depth, built_->drawn.smoothing,
                               static_cast<Index>(std::ceil(4 * built_->drawn.smoothing)));
  }
  if (store.normals) {
    sample_.normals =
        gelight::sobel_normals(sample_.depth, camera, gelight::BorderNormals::extrapolated);
    const auto none = Vec3<float>::Constant(std::numeric_limits<float>::quiet_NaN());
    for (auto& normal : sample_.normals.pixels()) {
      if (normal.isZero()) normal = none;
    }
  }
  if (store.force) press_back(sensor);
  if (store.markers) drag_markers(sensor);
}

// The force on a bed of springs under the membrane, along its normals. A pixel sees a point of the
// object; the spring under it stands where the normal through that point meets the membrane, which
// is another place than where the pixel saw the membrane at rest. Between the springs of four
// pixels that are neighbours, they are pressed as those are in the mean.
void Sampler::press_back(const LitSensor& sensor) {
  const auto camera = sensor.preset.camera.template cast<double>();
  struct Spring {
    Vec3<double> foot, normal;
    double pressed = 0;
  };
  const auto normal_at = [&](Index x, Index y) -> Vec3<double> {
    return sensor.normals(x, y).cast<double>();
  };
  const auto rest_at = [&](Index x, Index y) -> Vec3<double> {
    return camera.unproject(x, y, sensor.rest.depth(x, y));
  };
  const auto spring_at = [&](Index x, Index y) -> Spring {
    if (sample_.mask(x, y) == 0) return {rest_at(x, y), normal_at(x, y), 0};
    const Vec3<double> point = camera.unproject(x, y, object_depth_(x, y));
    Spring spring;
    for (int round = 0; round < 3; ++round) {  // nearer and nearer to its foot
      spring.normal = normal_at(x, y);
      spring.pressed = spring.normal.dot(point - rest_at(x, y));
      spring.foot = point - spring.pressed * spring.normal;
      const auto pixel = camera.project(spring.foot);
      const auto column = static_cast<Index>(std::clamp(pixel.x() + 0.5, 0.0, camera.width - 1.0));
      const auto row = static_cast<Index>(std::clamp(pixel.y() + 0.5, 0.0, camera.height - 1.0));
      if (sensor.normals(column, row).isZero()) break;
      x = column;
      y = row;
    }
    return spring;
  };
  const double stiffness = sample_.press[3] / scene_.gel_thickness;
  Vec3<double> force = Vec3<double>::Zero();
  for (Index y = 0; y + 1 < camera.height; ++y) {
    for (Index x = 0; x + 1 < camera.width; ++x) {
      const std::array<std::pair<Index, Index>, 4> corners{
          {{x, y}, {x + 1, y}, {x, y + 1}, {x + 1, y + 1}}};
      const auto is_pressed = [&](const auto& p) { return sample_.mask(p.first, p.second) != 0; };
      const auto is_seen = [&](const auto& p) {
        return !sensor.normals(p.first, p.second).isZero();
      };
      if (std::none_of(corners.begin(), corners.end(), is_pressed)) continue;
      if (!std::all_of(corners.begin(), corners.end(), is_seen)) continue;
      std::array<Spring, 4> springs;
      for (std::size_t i = 0; i < 4; ++i)
        springs[i] = spring_at(corners[i].first, corners[i].second);
      const auto& [a, b, c, d] = springs;
      const Vec3<double> normal = (a.normal + b.normal + c.normal + d.normal).normalized();
      const double area = -normal.dot((d.foot - a.foot).cross(c.foot - b.foot)) / 2;
      const double pressed = (a.pressed + b.pressed + c.pressed + d.pressed) / 4;
      force += stiffness * pressed * area * normal;
    }
  }
  for (Index i = 0; i < 3; ++i)
    sample_.force[static_cast<std::size_t>(i)] = static_cast<float>(force[i]);
}

// Markers on a grid over the image where the camera sees the membrane at rest, dragged by a disc as
// large as the contact.
void Sampler::drag_markers(const LitSensor& sensor) {
  const auto& camera = sensor.preset.camera;
  const auto columns = static_cast<std::size_t>(scene_.marker_columns);
  const auto rows = static_cast<std::size_t>(scene_.marker_rows);
  sample_.markers.assign(2 * columns * rows, std::numeric_limits<float>::quiet_NaN());
  gelight::Vec2<double> centre(0, 0);
  double count = 0, depth = 0;
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) {
      if (sample_.mask(x, y) == 0) continue;
      centre += gelight::Vec2<double>(x, y);
      depth += sensor.rest.depth(x, y);
      ++count;
    }
  }
  std::optional<gelight::DraggedMarkers> dragged;  // by what touches
  if (count > 0) {
    const double focal = camera.fx * count / depth;  // pixels a metre on the membrane
    dragged = gelight::DraggedMarkers::of_disc(centre / count,
                                               {focal * sample_.press[1], focal * sample_.press[2]},
                                               std::sqrt(count / std::numbers::pi), 0.48);
  }
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      const gelight::Vec2<double> at(camera.width * (double(c) + 0.5) / double(columns) - 0.5,
                                     camera.height * (double(r) + 0.5) / double(rows) - 0.5);
      const auto x = static_cast<Index>(at.x() + 0.5), y = static_cast<Index>(at.y() + 0.5);
      if (!std::isfinite(sensor.rest.depth(x, y))) continue;
      const gelight::Vec2<double> by = dragged ? (*dragged)(at) : gelight::Vec2<double>(0, 0);
      sample_.markers[2 * (r * columns + c)] = static_cast<float>(by.x());
      sample_.markers[2 * (r * columns + c) + 1] = static_cast<float>(by.y());
    }
  }
}
