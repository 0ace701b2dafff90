#include "scene.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <span>
#include <utility>

#include "../support/household.hpp"
#include "../support/mesh_file.hpp"
#include "../support/press.hpp"
#include "gelight/core/error.hpp"
#include "gelight/mesh/surface.hpp"

using gelight::Index;
using gelight::Mesh;
using gelight::detail::require;
using nlohmann::json;

namespace {

/// A value of the description, unless it is of another kind.
template <class T>
T value_of(const json& value, const std::string& where) {
  const auto require_that = [&](bool is_so, const auto&... kind) {
    require(is_so, where, " is ", value.dump(), ", not ", kind...);
  };
  if constexpr (std::is_same_v<T, json>) {
    return value;
  } else if constexpr (std::is_same_v<T, std::string>) {
    require_that(value.is_string(), "a text");
    const auto text = value.get<std::string>();
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; };
    require_that(std::none_of(text.begin(), text.end(), is_control), "a text of one line");
    return text;
  } else if constexpr (std::is_integral_v<T>) {
    constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<T>::max());
    // (JSON's -0 is a number with a sign.)
    const bool is_zero = value.is_number_integer() && value.get<std::int64_t>() == 0;
    require_that(is_zero || (value.is_number_unsigned() && value.get<std::uint64_t>() <= most),
                 "a whole number from 0 to ", most);
    return value.get<T>();
  } else if constexpr (std::is_floating_point_v<T>) {
    require_that(value.is_number(), "a number");
    return value.get<T>();
  } else {
    require_that(value.is_array(), "a list");
    T values;
    for (std::size_t i = 0; i < value.size(); ++i) {
      values.push_back(
          value_of<typename T::value_type>(value[i], where + "[" + std::to_string(i) + "]"));
    }
    return values;
  }
}

/// The keys of an object of the description, each of which is to be asked for.
class Entry {
 public:
  Entry(const json& object, std::string where) : object_(object), where_(std::move(where)) {
    require(object.is_object(), where_, " is ", object.dump(), ", not an object");
  }

  /// The value of a key; the default where it is not there and there is one.
  template <class T>
  T take(const std::string& key, const T& otherwise) {
    return has(key) ? value_of<T>(at(key), where_ + "." + key) : otherwise;
  }
  template <class T>
  T take(const std::string& key) {
    require(has(key), where_, " has no \"", key, "\"");
    return value_of<T>(at(key), where_ + "." + key);
  }

  /// A number from `least` to `most`.
  double number(const std::string& key, double otherwise, double least, double most) {
    const auto value = take<double>(key, otherwise);
    require(value >= least && value <= most, where_, ".", key, " is ", value, ", not from ", least,
            " to ", most);
    return value;
  }

  /// A number, or how it is spread; all that it can give lies from `least` to `most`.
  Distribution spread(const std::string& key, const Distribution& otherwise, double least,
                      double most, const std::string& bound = "") {
    if (!has(key)) return otherwise;
    const json& value = object_[key];
    const std::string where = where_ + "." + key;
    Distribution d;
    if (value.is_number()) {
      d.low = d.high = value.get<double>();
    } else if (value.is_array()) {
      d.kind = Distribution::Kind::uniform;
      ends(d, value, where);
    } else {
      require(value.is_object(), where, " is ", value.dump(), ", not a number or its spread");
      Entry named(value, where);
      spread_by_name(d, named, where, least, most);
      named.finish();
    }
    require(d.least() >= least && d.most() <= most, where, " is ", value.dump(),
            ", which reaches beyond ", least, " to ", most, bound);
    return d;
  }

  [[nodiscard]] bool has(const std::string& key) {
    asked_.insert(key);
    return object_.contains(key);
  }
  [[nodiscard]] const json& at(const std::string& key) { return object_[key]; }

  /// Refuses what nobody has asked for.
  void finish() const {
    for (const auto& [key, value] : object_.items()) {
      require(asked_.contains(key), where_, " has \"", key, "\", which means nothing");
    }
  }

 private:
  static void ends(Distribution& d, const json& value, const std::string& where) {
    require(value.is_array() && value.size() == 2 && value[0].is_number() && value[1].is_number() &&
                value[0] <= value[1],
            where, " is ", value.dump(), ", not [from, to]");
    d.low = value[0].get<double>();
    d.high = value[1].get<double>();
  }

  static void spread_by_name(Distribution& d, Entry& named, const std::string& where, double least,
                             double most) {
    if (named.has("log_uniform")) {
      d.kind = Distribution::Kind::log_uniform;
      ends(d, named.at("log_uniform"), where);
      require(d.low > 0, where, " begins at ", d.low, ", which has no logarithm");
    } else if (named.has("normal")) {
      const auto values = named.take<std::vector<double>>("normal");
      require(values.size() == 2 && values[1] > 0, where, " is not [mean, standard deviation]");
      d = {.kind = Distribution::Kind::normal,
           .low = least,
           .high = most,
           .mean = values[0],
           .spread = values[1],
           .choices = {}};
      if (named.has("within")) ends(d, named.at("within"), where);
      require(d.low <= d.mean && d.mean <= d.high, where, " has the mean ", d.mean,
              ", which lies outside of ", d.low, " to ", d.high);
    } else {
      require(named.has("one_of"), where, " has neither log_uniform nor normal nor one_of");
      d.kind = Distribution::Kind::one_of;
      d.choices = named.take<std::vector<double>>("one_of");
      require(!d.choices.empty(), where, " chooses among none");
    }
  }

  const json& object_;
  std::string where_;
  std::set<std::string> asked_;
};

Distribution constant(double value) { return {.low = value, .high = value, .choices = {}}; }
Distribution uniform(double low, double high) {
  return {.kind = Distribution::Kind::uniform, .low = low, .high = high, .choices = {}};
}

template <class M>
Mesh<float> as_float(const M& mesh, double unit) {
  const gelight::Surface<double> surface(mesh);
  Mesh<float> copy;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const gelight::Vec3<float> p = (unit * surface.position(v)).template cast<float>();
    copy.positions.push_back({p[0], p[1], p[2]});
  }
  for (Index f = 0; f < surface.face_count(); ++f) copy.faces.push_back(surface.face(f));
  return copy;
}

Mesh<float> mesh_of_shape(const std::string& name) {
  std::string all;
  for (const Press& press : objects_to_press()) {
    if (press.name == name) return as_float(press.object, 1);
    all += " " + press.name + ",";
  }
  for (const Thing& thing : things_from_a_drawer()) {
    if (thing.name == name) return as_float(thing.mesh, 1);
    all += " " + thing.name + ",";
  }
  gelight::detail::refuse(
      {"there is no shape \"", name, "\"; there are", all.substr(0, all.size() - 1)});
}

/// A number that another mesh has not: a file may change while its name does not.
std::uint64_t digest(const Mesh<float>& mesh) {
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&](std::span<const std::byte> bytes) {
    for (const std::byte b : bytes) hash = (hash ^ static_cast<std::uint64_t>(b)) * 1099511628211U;
  };
  add(std::as_bytes(std::span(mesh.positions)));
  add(std::as_bytes(std::span(mesh.faces)));
  return hash;
}

/// The largest side of the box about a mesh.
double extent_of(const Mesh<float>& mesh) {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [low, high] =
        std::minmax_element(mesh.positions.begin(), mesh.positions.end(),
                            [i](const auto& p, const auto& q) { return p[i] < q[i]; });
    largest = std::max(largest, double{(*high)[i]} - double{(*low)[i]});
  }
  return largest;
}

ObjectRange read_object(const json& value, const std::string& where,
                        const std::filesystem::path& folder) {
  Entry entry(value, where);
  ObjectRange object;
  require(entry.has("shape") != entry.has("mesh"), where, " needs a \"shape\" or a \"mesh\"");
  if (entry.has("shape")) {
    object.name = entry.take<std::string>("shape");
    object.mesh = mesh_of_shape(object.name);
  } else {
    const auto path = folder / entry.take<std::string>("mesh");
    object.name = path.stem().string();
    const Mesh<double> mesh = mesh_of_file(path);
    require_precision<float>(mesh, path.string());
    object.mesh = as_float(mesh, entry.number("unit", 1, 1e-9, 1e6));
  }
  object.name = entry.take<std::string>("name", object.name);
  require(!object.mesh.positions.empty(), where, " has no vertices");
  object.size = entry.spread("size", constant(1), 1e-6, 1e6);
  const double extent = extent_of(object.mesh);
  require(extent * object.size.most() <= 1 && extent * object.size.least() >= 1e-5, where, " is ",
          extent * object.size.least(), " to ", extent * object.size.most(),
          " m large, not from 0.00001 to 1 m: see its \"unit\", in metres, and its \"size\"");
  entry.finish();
  return object;
}

SensorRange read_sensor(const json& value, const std::string& where) {
  Entry entry(value, where);
  SensorRange sensor;
  const auto one_of = [&](const char* key, const std::string& otherwise,
                          const std::vector<std::string>& names) {
    const auto name = entry.take<std::string>(key, otherwise);
    require(std::find(names.begin(), names.end(), name) != names.end(), where, ".", key, " is \"",
            name, "\", which is not known");
    return name;
  };
  sensor.model = one_of("model", "geltip", {"geltip", "gelsight_mini", "digit", "sts"});
  sensor.light = one_of("light", "geodesic", {"linear", "plane", "geodesic", "transport"});
  sensor.name = entry.take<std::string>("name", sensor.model + ", " + sensor.light);
  sensor.edge = entry.number("edge", 0.001, 1e-4, 0.02);
  sensor.brightness = entry.spread("brightness", constant(1), 0, 1);
  sensor.ambient = entry.spread("ambient", constant(0.9), 0, 1);
  const bool is_sts = sensor.model == "sts";
  sensor.diffuse = entry.spread("diffuse", constant(is_sts ? 1 : 0.5), 0, 10);
  sensor.specular = entry.spread("specular", constant(is_sts ? 0.5 : 0.1), 0, 10);
  sensor.shininess = entry.spread("shininess", constant(is_sts ? 5 : 100), 0, 1000);
  sensor.smoothing = entry.spread("smoothing", constant(5), 0, 20);
  entry.finish();
  return sensor;
}

Stored read_stored(const std::vector<std::string>& names) {
  Stored store;
  const std::pair<const char*, bool*> all[] = {{"image", &store.image}, {"mask", &store.mask},
                                               {"depth", &store.depth}, {"normals", &store.normals},
                                               {"force", &store.force}, {"markers", &store.markers},
                                               {"pose", &store.pose},   {"seed", &store.seed}};
  for (const std::string& name : names) {
    const auto found = std::find_if(std::begin(all), std::end(all),
                                    [&](const auto& known) { return known.first == name; });
    require(found != std::end(all), "the scene's store has \"", name, "\", which is not known");
    *found->second = true;
  }
  return store;
}

void read_pose(Scene& scene, const json& value) {
  Entry pose(value, "the scene's pose");
  constexpr double turn = 2 * std::numbers::pi;
  scene.column = pose.spread("column", uniform(0.2, 0.8), 0, 1);
  scene.row = pose.spread("row", uniform(0.2, 0.8), 0, 1);
  scene.spin = pose.spread("spin", uniform(0, turn), -turn, turn);
  scene.lean = pose.spread("lean", constant(0), 0, turn / 2);
  const double thick = scene.gel_thickness;
  scene.depth = pose.spread("depth", uniform(std::min(0.0005, thick), std::min(0.002, thick)), 0,
                            thick, ", as deep as the gel is thick");
  scene.shift = pose.spread("shift", constant(0), -0.01, 0.01);
  pose.finish();
}

void read_gel(Scene& scene, const json& value) {
  Entry gel(value, "the scene's gel");
  scene.modulus = gel.spread("modulus", constant(1e5), 1, 1e9);
  scene.gel_thickness = gel.number("thickness", 0.004, 1e-5, 0.1);
  gel.finish();
}

Scene scene_of(const json& description, const std::filesystem::path& folder) {
  Entry entry(description, "the scene");
  Scene scene;
  scene.text = description.dump();
  json of_a_sample = description;
  of_a_sample.erase("samples");
  scene.sample_text = of_a_sample.dump();
  scene.seed = entry.take<std::uint64_t>("seed", 1);
  scene.samples = entry.take<std::uint64_t>("samples");
  scene.sensor_every = entry.take<std::uint64_t>("sensor_every", 256);
  const auto size = entry.take<std::vector<Index>>("image", {320, 240});
  require(size.size() == 2 && size[0] > 3 && size[1] > 3 && size[0] <= 8192 && size[1] <= 8192,
          "the scene's image is not [columns, rows] of 4 to 8192");
  scene.width = size[0];
  scene.height = size[1];
  // (As many as make a file of some 10 MB, for it is made in memory.)
  const std::uint64_t usual = std::clamp(
      128 * 320 * 240 / (static_cast<std::uint64_t>(size[0]) * static_cast<std::uint64_t>(size[1])),
      std::uint64_t{1}, std::uint64_t{128});
  scene.part = entry.take<std::uint64_t>("part", usual);
  require(scene.samples > 0 && scene.part > 0 && scene.sensor_every > 0,
          "the scene's samples, part and sensor_every are to be 1 or more");
  require(scene.samples / scene.part < 1000000, scene.samples, " samples by ", scene.part,
          " a part are more than a million files");
  scene.store =
      read_stored(entry.take<std::vector<std::string>>("store", {"image", "mask", "pose"}));
  const auto sensors = entry.take<std::vector<json>>("sensors", {json::object()});
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    scene.sensors.push_back(read_sensor(sensors[i], "sensors[" + std::to_string(i) + "]"));
  }
  const auto objects = entry.take<std::vector<json>>("objects");
  for (std::size_t i = 0; i < objects.size(); ++i) {
    scene.objects.push_back(read_object(objects[i], "objects[" + std::to_string(i) + "]", folder));
    const std::string mesh = "\nobject " + std::to_string(digest(scene.objects.back().mesh));
    scene.text += mesh;
    scene.sample_text += mesh;
  }
  require(!scene.sensors.empty(), "the scene's sensors are an empty list");
  require(!scene.objects.empty(), "the scene's objects are an empty list");
  read_gel(scene, entry.take<json>("gel", json::object()));
  read_pose(scene, entry.take<json>("pose", json::object()));
  const auto markers = entry.take<std::vector<int>>("markers", {9, 7});
  require(markers.size() == 2 && markers[0] > 0 && markers[1] > 0 && markers[0] <= 1000 &&
              markers[1] <= 1000,
          "the scene's markers are not [columns, rows] of 1 to 1000");
  scene.marker_columns = markers[0];
  scene.marker_rows = markers[1];
  entry.finish();
  return scene;
}

/// Refuses an object that names a key twice, of which JSON's readers keep the last, and lists in
/// lists so deep that writing them out, which recurses, would end the program.
json parsed(std::istream& file) {
  std::vector<std::set<std::string>> keys;
  const auto look = [&](int depth, json::parse_event_t event, json& value) {
    require(depth < 32, "it nests lists and objects 32 deep");
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key) {
      require(keys.back().insert(value.get<std::string>()).second, "it has ", value.dump(),
              " twice in one place");
    }
    return true;
  };
  return json::parse(file, look, true, true);
}

}  // namespace

Scene read_scene(const std::string& path) {
  std::ifstream file(path);
  require(file.good(), "there is no description ", path);
  require(!std::filesystem::is_directory(path), path, " is a folder, not a description");
  json description;
  try {
    description = parsed(file);
  } catch (const json::exception& why) {
    gelight::detail::refuse({path, " is not JSON: ", why.what()});
  } catch (const gelight::InvalidInput& why) {
    gelight::detail::refuse({path, ": ", why.what()});
  }
  try {
    return scene_of(description, std::filesystem::path(path).parent_path());
  } catch (const gelight::InvalidInput& why) {
    gelight::detail::refuse({path, ": ", why.what()});
  }
}
