#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/planning/contacts.hpp"
#include "gelight/sensor/planning/membrane_lights.hpp"
#include "gelight/sensor/planning/membranes.hpp"
#include "gelight/sensor/presets.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A sensor with a membrane of any mesh edge length, in m.
using SensorAt = std::function<SensorPreset<double>(double)>;

namespace detail {

/// What a planner chooses.
enum class SensorTopic : std::uint8_t { edges, light, grid, smoothing, precision };
inline constexpr std::array<SensorTopic, 5> all_topics{SensorTopic::edges, SensorTopic::light,
                                                       SensorTopic::grid, SensorTopic::smoothing,
                                                       SensorTopic::precision};

[[nodiscard]] inline const char* name_of(SensorTopic topic) {
  constexpr std::array<const char*, 5> names{"mesh edges", "light model", "light grid", "smoothing",
                                             "precision"};
  return names[static_cast<std::size_t>(topic)];
}
[[nodiscard]] inline const char* name_of(PlannedLight light) {
  constexpr std::array<const char*, 5> names{"linear", "gel", "plane", "transport", "geodesic"};
  return names[static_cast<std::size_t>(light)];
}

/// A chain from mesh to image.
struct SensorChoice {
  std::size_t mesh = 0;  // of the trials' meshes, the finest first
  PlannedLight light = PlannedLight::geodesic;
  Index grid = 1;          // pixels between the places where light is computed
  Index radius = 0;        // pixels: where the Gaussian is cut off; 0: there is none
  bool is_single = false;  // whether frames are rendered in float
  PlannedMembrane membrane = PlannedMembrane::gaussian;
  double sigma = 0;  // pixels, of the Gaussian

  /// Becomes like another in one thing.
  void take(SensorTopic topic, const SensorChoice& other) {
    if (topic == SensorTopic::edges) mesh = other.mesh;
    if (topic == SensorTopic::light) light = other.light;
    if (topic == SensorTopic::grid) grid = other.grid;
    if (topic == SensorTopic::smoothing) {
      membrane = other.membrane, sigma = other.sigma, radius = other.radius;
    }
    if (topic == SensorTopic::precision) is_single = other.is_single;
  }
  [[nodiscard]] bool has_same(SensorTopic topic, const SensorChoice& other) const {
    SensorChoice like_other = *this;
    like_other.take(topic, other);
    return like_other == *this;
  }
  [[nodiscard]] bool is_no_more_exact_than(const SensorChoice& other) const {
    return light == other.light && has_same_model(other) && mesh >= other.mesh &&
           grid >= other.grid && radius <= other.radius && is_single >= other.is_single;
  }
  /// Whether the membranes differ at most by where a Gaussian is cut off.
  [[nodiscard]] bool has_same_model(const SensorChoice& other) const {
    return membrane == other.membrane && sigma == other.sigma;
  }
  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 sees a 0 in what the compiler writes
  friend auto operator<=>(const SensorChoice&, const SensorChoice&) = default;
};

/// A part of a sensor's image.
struct TrialImages {
  Image<Rgb8> pressed, rest;
};

/// How many of the pixels that each contact changes are off by how many grey levels.
class TrialErrors {
 public:
  /// Of one more contact: images and those of the membrane at rest, ours and the reference's.
  void add(const TrialContact& contact, const TrialImages& ours, const TrialImages& truth) {
    auto& counts = counts_.emplace_back();
    const Window counted = contact.counted_in_lit();
    for (Index y = counted.top; y < counted.bottom; ++y) {
      for (Index x = counted.left; x < counted.right; ++x) {
        const Rgb8 &image = ours.pressed(x, y), &reference = truth.pressed(x, y);
        if (image == ours.rest(x, y) && reference == truth.rest(x, y)) continue;
        int off = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          off = std::max(off, std::abs(int{image[c]} - int{reference[c]}));
        }
        counts[static_cast<std::size_t>(off)] += contact.weight;
      }
    }
  }

  /// The share of the pixels that are off by no more than so many levels.
  [[nodiscard]] double within(double levels) const {
    double good = 0, all = 0;
    for (const auto& counts : counts_) {
      good += pixels_within(counts, levels);
      all += pixels_within(counts, 255);
    }
    return all > 0 ? good / all : 1;
  }
  /// The standard error of that, contacts being drawn by lot: of a ratio.
  [[nodiscard]] double standard_error(double levels) const {
    const double share = within(levels), count = static_cast<double>(counts_.size());
    double squares = 0, all = 0;
    for (const auto& counts : counts_) {
      const double pixels = pixels_within(counts, 255);
      squares += std::pow(pixels_within(counts, levels) - share * pixels, 2);
      all += pixels;
    }
    return all > 0 ? std::sqrt(squares * count / (count - 1)) / all : 0;
  }
  /// Of how many levels so many pixels are within, with some standard errors to spare.
  [[nodiscard]] int level_of(double share, double sureness) const {
    int level = 0;
    while (level < 255 && within(level) - sureness * standard_error(level) < share) ++level;
    return level;
  }

 private:
  using Counts = std::array<double, 256>;
  [[nodiscard]] static double pixels_within(const Counts& counts, double levels) {
    double sum = 0;
    for (std::size_t i = 0; i < counts.size() && static_cast<double>(i) <= levels; ++i) {
      sum += counts[i];
    }
    return sum;
  }

  std::vector<Counts> counts_;  // of each contact
};

/// What a camera, or a part of it, sees of a membrane at rest.
struct SeenMembrane {
  Camera<double> camera;
  Image<double> rest;
  Image<std::array<double, 3>> coating;
};

/// A part of an image.
template <class P>
[[nodiscard]] Image<P> cut_out(const Image<P>& image, const Window& window) {
  Image<P> part(window.right - window.left, window.bottom - window.top);
  for (Index y = 0; y < part.height(); ++y) {
    std::copy_n(image.row(window.top + y) + window.left, part.width(), part.row(y));
  }
  return part;
}

/// The pixels of a window, of a light field on a coarse grid made as large as the camera's image.
[[nodiscard]] inline Image<Vec3<double>> resized_window(const Image<Vec3<double>>& field,
                                                        const Camera<double>& camera,
                                                        const Window& window) {
  Image<Vec3<double>> result(window.right - window.left, window.bottom - window.top);
  resize_into(result, field, camera.width, camera.height, window.left, window.top);
  return result;
}

/// Depths in another precision.
template <std::floating_point T>
[[nodiscard]] Image<T> rounded(const Image<double>& depth) {
  Image<T> result(depth.width(), depth.height());
  for (std::size_t i = 0; i < result.pixels().size(); ++i) {
    result.pixels()[i] = static_cast<T>(depth.pixels()[i]);
  }
  return result;
}

/// The Gaussian membrane of a chain.
template <std::floating_point T>
[[nodiscard]] GaussianMembrane<T> gaussian_of(const SensorPreset<double>& sensor,
                                              const SensorChoice& choice) {
  return GaussianMembrane<T>(choice.radius == 0 ? 0 : choice.sigma, choice.radius,
                             sensor.options.clip_to_rest);
}

/// A membrane's depth at rest, NaN where there is none.
///@{
template <std::floating_point T>
[[nodiscard]] Image<T> rest_of(const Image<double>& depth) {
  Image<T> rest = rounded<T>(depth);
  for (T& z : rest.pixels()) z = surface_or_nan(z);
  return rest;
}
template <std::floating_point T>
[[nodiscard]] Image<T> rest_of(const Raster<double>& raster) {
  return rest_of<T>(raster.depth);
}
///@}

/// A membrane whose surface is computed beforehand: that of an image, which may be another one from
/// frame to frame.
template <std::floating_point T>
class KnownMembrane {
 public:
  /// What moves it may lie beside the image.
  static constexpr bool moves_untouched = true;

  struct Workspace {};
  explicit KnownMembrane(const Image<T>& surface) : surface_(&surface) {}
  [[nodiscard]] Index reach() const { return whole_image; }
  [[nodiscard]] Workspace make_workspace(Index, Index) const { return {}; }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace&) const {
    const Window& window = press.window;
    for (Index y = window.top; y < window.bottom; ++y) {
      for (Index x = window.left; x < window.right; ++x) surface(x, y) = (*surface_)(x, y);
    }
  }

 private:
  const Image<T>* surface_;
};

/// The renderer of a chain, for what a camera sees, each LED's light there, and a membrane model.
template <std::floating_point T, MembraneModel<T> Membrane>
[[nodiscard]] TactileRenderer<T, Membrane> renderer_of(
    const SensorPreset<double>& sensor, const SeenMembrane& seen,
    const std::vector<Image<Vec3<double>>>& fields, const SensorChoice& choice, Membrane membrane) {
  const Index width = seen.camera.width, height = seen.camera.height;
  std::vector<Light<T>> lights;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    Light<T> light{Image<Vec3<T>>(width, height),
                   {},
                   static_cast<T>(sensor.diffuse),
                   static_cast<T>(sensor.specular),
                   static_cast<T>(sensor.shininess)};
    for (std::size_t c = 0; c < 3; ++c) light.rgb[c] = static_cast<T>(sensor.colours[k][c]);
    for (std::size_t i = 0; i < fields[k].pixels().size(); ++i) {
      light.direction.pixels()[i] = cast<T>(fields[k].pixels()[i]);
    }
    lights.push_back(std::move(light));
  }
  TactileOptions options = sensor.options;
  options.rectify = is_tangent(choice.light);
  options.keep_strength = sensor.led_width.value_or(0) > 0;
  Image<std::array<T, 3>> coating(width, height);
  for (std::size_t i = 0; i < coating.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      coating.pixels()[i][c] = static_cast<T>(seen.coating.pixels()[i][c]);
    }
  }
  const Camera<T> camera = seen.camera.template cast<T>();
  const Image<T> rest = rounded<T>(seen.rest);
  // As the preset's own renderer has it.
  if (!options.rectify) coating = beside_lights(std::move(coating), camera, rest, lights, options);
  return {camera, rest, std::move(membrane),
          PhongLights<T>{std::move(lights), Background<T>(std::move(coating)), options.ambient,
                         options.specular, options.rectify, options.keep_strength},
          FrameOptions{options.darkening, options.darkening_depth, options.border_normals,
                       options.skip_unchanged}};
}

/// How large what a sensor's chain works on is.
struct SensorSizes {
  double width = 0, height = 0;  // of the image, pixels
  double seen = 0;               // pixels that see the membrane
  double leds = 0;
  std::vector<double> vertices;                 // of each mesh
  std::vector<std::array<double, 2>> contacts;  // columns and rows of each
};

/// Renders contacts drawn by lot with one choice after the other, beside the reference.
class SensorTrials {
 public:
  /// What is pressed in.
  struct Contacts {
    double radius, depth;
    Index count;
    std::uint64_t seed;
  };

  SensorTrials(const SensorAt& sensor_at, double reference_edge, const Contacts& contacts,
               PlannedLight light, PlannedMembrane membrane, const CancelHook& cancelled)
      : reference_light_(light), reference_membrane_(membrane), cancelled_(cancelled) {
    make_meshes(sensor_at, reference_edge);
    sigma_ = checked_sigma(meshes_[0]->sensor.options.smoothing_sigma);
    draw(contacts);
    if (membrane != PlannedMembrane::gaussian) find_gel_sigma(contacts.radius);
    SensorChoice reference = most_exact();
    reference.mesh = 0;
    if (membrane == PlannedMembrane::gaussian) reference.radius = radius_of(reference_sigmas);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      cancelled_.check(0, what);
      references_.push_back(images<double>(reference, i));
    }
  }

  [[nodiscard]] double edge(const SensorChoice& choice) const { return meshes_[choice.mesh]->edge; }

  /// The most exact of what may be chosen.
  [[nodiscard]] SensorChoice most_exact() const {
    SensorChoice choice{1, reference_light_, 1, 0, false, reference_membrane_, 0};
    if (reference_membrane_ == PlannedMembrane::gaussian) {
      choice.sigma = sigma_;
      choice.radius = radius_of(sigmas.back());
    }
    return choice;
  }

  /// All that may be chosen of a topic, the coarsest first, but for one membrane or light model
  /// after the other; else like the most exact choice.
  [[nodiscard]] std::vector<SensorChoice> choices(SensorTopic topic) const {
    std::vector<SensorChoice> all;
    const auto add = [&](auto SensorChoice::*member, auto value) {
      SensorChoice choice = most_exact();
      choice.*member = value;
      if (all.empty() || !(all.back() == choice)) all.push_back(choice);
    };
    switch (topic) {
      case SensorTopic::edges:
        for (std::size_t m = meshes_.size() - 1; m > 0; --m) add(&SensorChoice::mesh, m);
        break;
      case SensorTopic::light:
        for (int i = 0; i <= static_cast<int>(reference_light_); ++i) {
          add(&SensorChoice::light, static_cast<PlannedLight>(i));
        }
        break;
      case SensorTopic::grid:
        for (const Index grid : grids) add(&SensorChoice::grid, grid);
        break;
      case SensorTopic::smoothing:
        return membranes();
      default:
        add(&SensorChoice::is_single, true);
        add(&SensorChoice::is_single, false);
    }
    return all;
  }

  /// What a topic's choice is, in words.
  [[nodiscard]] std::string words(SensorTopic topic, const SensorChoice& choice) const {
    switch (topic) {
      case SensorTopic::edges:
        return two_digits(1e3 * edge(choice)) + " mm";
      case SensorTopic::light:
        return name_of(choice.light);
      case SensorTopic::grid:
        return joined("every ", choice.grid, " pixels");
      case SensorTopic::smoothing:
        if (choice.membrane != PlannedMembrane::gaussian) return name_of(choice.membrane);
        return choice.radius == 0 ? "none"
                                  : joined("Gaussian of ", two_digits(choice.sigma),
                                           " pixels cut off at ", choice.radius, ", ",
                                           two_digits(choice.radius / choice.sigma), " sigma");
      default:
        return choice.is_single ? "float" : "double";
    }
  }

  /// How far a choice is off.
  [[nodiscard]] const TrialErrors& errors(const SensorChoice& choice) {
    const auto known = errors_.find(choice);
    if (known != errors_.end()) return known->second;
    TrialErrors result;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      cancelled_.check(done(), what);
      const TrialImages ours =
          choice.is_single ? images<float>(choice, i) : images<double>(choice, i);
      result.add(contacts_[i], ours, references_[i]);
    }
    return errors_.emplace(choice, std::move(result)).first->second;
  }
  [[nodiscard]] bool is_known(const SensorChoice& choice) const { return errors_.contains(choice); }

  [[nodiscard]] SensorSizes sizes() const {
    const auto& sensor = meshes_[0]->sensor;
    SensorSizes sizes{static_cast<double>(sensor.camera.width),
                      static_cast<double>(sensor.camera.height),
                      0,
                      static_cast<double>(sensor.leds.size()),
                      {},
                      {}};
    for (const Index face : meshes_[0]->rest->face.pixels()) sizes.seen += face >= 0;
    for (const auto& mesh : meshes_) {
      sizes.vertices.push_back(static_cast<double>(mesh->sensor.membrane.positions.size()));
    }
    for (const auto& contact : contacts_) {
      sizes.contacts.push_back(
          {static_cast<double>(contact.across), static_cast<double>(contact.down)});
    }
    return sizes;
  }

 private:
  static constexpr const char* what = "planning a sensor";
  static constexpr double reference_sigmas = 6;
  static constexpr std::array<double, 8> sigmas{1, 1.5, 2, 2.5, 3, 3.5, 4, 5};
  static constexpr std::array<Index, 9> grids{48, 32, 24, 16, 12, 8, 6, 4, 1};
  static constexpr int most_meshes = 14;

  using Field = Image<Vec3<double>>;
  /// What is known of one mesh, each part once it is needed.
  struct Mesh {
    Mesh(SensorPreset<double> of, double edge_length)
        : sensor(std::move(of)), edge(edge_length), lights(sensor) {}

    SensorPreset<double> sensor;
    double edge;
    MembraneLights lights;
    std::optional<Raster<double>> rest;
    std::optional<std::size_t> alike;                              // the first mesh as it is seen
    std::vector<SeenMembrane> seen;                                // at each contact
    std::map<PlannedLight, std::vector<std::vector<Field>>> fine;  // at each contact, of each LED
    std::map<std::pair<PlannedLight, Index>, std::vector<Field>> coarse;  // of each LED
    std::map<std::pair<PlannedLight, Index>, std::vector<std::vector<Field>>> resized;
  };

  [[nodiscard]] Index radius_of(double times_sigma) const { return radius_of(times_sigma, sigma_); }
  [[nodiscard]] static Index radius_of(double times_sigma, double sigma) {
    return static_cast<Index>(std::ceil(times_sigma * sigma));
  }

  [[nodiscard]] static double checked_sigma(double sigma) {
    constexpr double most = TactileOptions::widest_sigma;
    require(sigma >= 0 && sigma <= most, "a smoothing sigma of ", sigma,
            " pixels is not between 0 and ", most);
    return sigma;
  }

  // The sigma, in pixels, with which a Gaussian is nearest to the gel's layer.
  void find_gel_sigma(double contact_radius) {
    const auto& sensor = with_rest(0).sensor;
    for (const auto& contact : contacts_) {
      require(contact.slant <= ElasticLayer<double>::most_bend, "a membrane that is ",
              contact.slant, " radians from across the camera's axis is no layer that is pressed ",
              "along it: of such a sensor the Gaussian is the membrane to plan with");
    }
    const double pixel = mean_rest(rest_of<double>(*with_rest(0).rest)) / sensor.camera.fx;
    gel_sigma_ = checked_sigma(gaussian_sigma(sensor.gel, contact_radius) / pixel);
  }

  // From none over Gaussians of the preset's and the gel's sigma to the reference's.
  [[nodiscard]] std::vector<SensorChoice> membranes() const {
    std::vector<SensorChoice> all;
    const auto add = [&](PlannedMembrane membrane, double sigma, Index radius) {
      SensorChoice choice = most_exact();
      choice.membrane = membrane, choice.sigma = sigma, choice.radius = radius;
      if (all.empty() || !(all.back() == choice)) all.push_back(choice);
    };
    add(PlannedMembrane::gaussian, sigma_, 0);
    for (const double s : sigmas) add(PlannedMembrane::gaussian, sigma_, radius_of(s));
    if (reference_membrane_ == PlannedMembrane::gaussian) return all;
    for (const double s : sigmas) {
      add(PlannedMembrane::gaussian, gel_sigma_, radius_of(s, gel_sigma_));
    }
    for (int i = 1; i <= static_cast<int>(reference_membrane_); ++i) {
      add(static_cast<PlannedMembrane>(i), 0, 0);
    }
    return all;
  }
  // Nobody knows how many trials there will be.
  [[nodiscard]] double done() const {
    const auto trials = static_cast<double>(errors_.size());
    return trials / (trials + 20);
  }

  void make_meshes(const SensorAt& sensor_at, double edge) {
    meshes_.push_back(std::make_unique<Mesh>(sensor_at(edge), edge));
    for (int k = 2; k < most_meshes; ++k) {
      const double coarser = edge * std::exp2(0.5 * k);
      try {
        meshes_.push_back(std::make_unique<Mesh>(sensor_at(coarser), coarser));
      } catch (const InvalidInput&) {
        break;  // coarser than the sensor can be
      }
    }
    require(meshes_.size() > 1, "the sensor has no mesh with edges of ", 2 * edge);
  }

  void draw(const Contacts& contacts) {
    const Mesh& mesh = with_rest(0);
    const Surface<double> surface(mesh.sensor.membrane);
    ContactDraw next(surface, mesh.sensor.camera, *mesh.rest, contacts.radius, contacts.depth,
                     contacts.seed);
    for (Index i = 0; i < contacts.count; ++i) {
      cancelled_.check(0, what);
      contacts_.push_back(next.next(radius_of(3), radius_of(reference_sigmas)));
    }
  }

  Mesh& with_rest(std::size_t m) {
    Mesh& mesh = *meshes_[m];
    if (!mesh.rest) mesh.rest = rasterize(mesh.sensor.membrane, mesh.sensor.camera);
    return mesh;
  }

  const SeenMembrane& seen(std::size_t m, std::size_t contact) {
    Mesh& mesh = with_rest(m);
    for (std::size_t i = mesh.seen.size(); i < contacts_.size(); ++i) {
      const Window lit = contacts_[i].lit();
      Camera<double> camera = mesh.sensor.camera;
      camera.cx -= lit.left, camera.cy -= lit.top;
      camera.width = lit.right - lit.left, camera.height = lit.bottom - lit.top;
      const Raster<double> part{cut_out(mesh.rest->depth, lit), cut_out(mesh.rest->face, lit),
                                cut_out(mesh.rest->barycentric, lit)};
      mesh.seen.push_back(
          {camera, part.depth, seen_coating(mesh.sensor, mesh.lights.surface(), camera, part)});
    }
    return mesh.seen[contact];
  }

  // The membrane under a contact where that is lit, smoothed from all of the contact's window.
  template <std::floating_point T>
  const Image<T>& pressed(const SensorChoice& choice, std::size_t contact) {
    auto& surfaces = std::get<Surfaces<T>>(surfaces_);
    const bool is_gaussian = choice.membrane == PlannedMembrane::gaussian;
    const std::size_t m = is_gaussian ? choice.mesh : alike(choice.mesh);
    const std::tuple key(m, choice.membrane, choice.sigma, choice.radius, contact);
    const auto known = surfaces.find(key);
    if (known != surfaces.end()) return known->second;
    return surfaces.emplace(key, newly_pressed<T>(choice, m, contact)).first->second;
  }

  template <std::floating_point T>
  Image<T> newly_pressed(const SensorChoice& choice, std::size_t m, std::size_t contact) {
    if (choice.membrane == PlannedMembrane::gaussian) {
      return pressed_gaussian<T>(choice, contacts_[contact]);
    }
    // A layer of floats is computed in double, too, and rounded in the end.
    if constexpr (!std::same_as<T, double>) {
      if (choice.membrane == PlannedMembrane::layer) {
        return rounded<T>(pressed<double>(choice, contact));
      }
    }
    return pressed_gel<T>(m, choice.membrane, contacts_[contact]);
  }

  // The first mesh that the camera sees as it sees this one, but for rounding, as it does all of a
  // flat pad: a gel takes long to press.
  std::size_t alike(std::size_t m) {
    std::optional<std::size_t>& known = with_rest(m).alike;
    for (std::size_t other = 0; !known; ++other) {
      if (other == m || look_alike(with_rest(other), *meshes_[m])) known = other;
    }
    return *known;
  }
  [[nodiscard]] static bool look_alike(const Mesh& a, const Mesh& b) {
    const auto& one = a.rest->depth.pixels();
    return std::equal(one.begin(), one.end(), b.rest->depth.pixels().begin(),
                      [](double x, double y) { return x == y || std::abs(x - y) <= 1e-12 * x; });
  }

  template <std::floating_point T>
  Image<T> pressed_gaussian(const SensorChoice& choice, const TrialContact& object) {
    const Mesh& mesh = with_rest(choice.mesh);
    const Image<T> depth = rounded<T>(object.depth);
    const Image<T> rest = rest_of<T>(cut_out(mesh.rest->depth, object.window));
    Image<T> surface(depth.width(), depth.height());
    const auto membrane = gaussian_of<T>(mesh.sensor, choice);
    auto work = membrane.make_workspace(depth.width(), depth.height());
    const Window lit = object.lit_in_window();
    membrane.press_into(surface, {depth, rest, lit}, work);
    return cut_out(surface, lit);
  }

  // All of the object counts, wherever that is.
  template <std::floating_point T>
  Image<T> pressed_gel(std::size_t m, PlannedMembrane membrane, const TrialContact& object) {
    const Mesh& mesh = with_rest(m);
    const Image<T> rest = rest_of<T>(*mesh.rest);
    auto& gels = std::get<Gels<T>>(gels_);
    auto known = gels.find({m, membrane});
    if (known == gels.end()) {
      auto made = gel_membrane<T>(membrane, mesh.sensor.camera, rest,
                                  mean_rest(rest_of<double>(*mesh.rest)), mesh.sensor.gel, {});
      known = gels.emplace(std::pair(m, membrane), std::move(made)).first;
    }
    const Image<T> depth = rounded<T>(object.whole);
    Image<T> surface(depth.width(), depth.height());
    auto work = known->second.make_workspace(depth.width(), depth.height());
    known->second.press_into(surface, {depth, rest, object.lit()}, work);
    return cut_out(surface, object.lit());
  }

  // Light at the contacts' pixels, of all LEDs: one solve for each.
  const std::vector<Field>& fine_fields(std::size_t m, PlannedLight light, std::size_t contact) {
    Mesh& mesh = with_rest(m);
    auto& fields = mesh.fine[light];
    if (!fields.empty()) return fields[contact];
    std::vector<Raster<double>> parts;
    for (const auto& one : contacts_) {
      parts.push_back({cut_out(mesh.rest->depth, one.lit()), cut_out(mesh.rest->face, one.lit()),
                       cut_out(mesh.rest->barycentric, one.lit())});
    }
    fields = by_part(baked(mesh, light, parts), parts.size());
    return fields[contact];
  }

  // The same on grids, all of them at once.
  const std::vector<Field>& coarse_fields(std::size_t m, PlannedLight light, Index grid) {
    Mesh& mesh = with_rest(m);
    const auto known = mesh.coarse.find({light, grid});
    if (known != mesh.coarse.end()) return known->second;
    std::vector<Raster<double>> parts;
    for (const Index g : grids) {
      if (g > 1) {
        parts.push_back(rasterize(mesh.sensor.membrane, coarse_camera(mesh.sensor.camera, g)));
      }
    }
    const auto fields = by_part(baked(mesh, light, parts), parts.size());
    for (std::size_t i = 0; i < fields.size(); ++i) mesh.coarse[{light, grids[i]}] = fields[i];
    return mesh.coarse[{light, grid}];
  }

  // Of each LED, the light in each part.
  [[nodiscard]] std::vector<std::vector<Field>> baked(
      const Mesh& mesh, PlannedLight light, const std::vector<Raster<double>>& parts) const {
    std::vector<SurfacePoint<double>> points;
    std::vector<std::size_t> ends;
    for (const auto& part : parts) {
      const auto more = pixel_points(part);
      points.insert(points.end(), more.begin(), more.end());
      ends.push_back(points.size());
    }
    std::vector<std::vector<Field>> result;
    for (std::size_t k = 0; k < mesh.sensor.leds.size(); ++k) {
      const CancelHook asked([this](double) {
        cancelled_.check(done(), what);
        return false;
      });
      const auto field = mesh.lights.field(light, k, points, cancelled_ ? asked : CancelHook());
      result.emplace_back();
      std::size_t begin = 0;
      for (std::size_t i = 0; i < parts.size(); begin = ends[i++]) {
        result.back().push_back(bake(std::span(field).subspan(begin, ends[i] - begin), parts[i]));
      }
    }
    return result;
  }
  static std::vector<std::vector<Field>> by_part(std::vector<std::vector<Field>> by_led,
                                                 std::size_t parts) {
    std::vector<std::vector<Field>> result(parts);
    for (auto& fields : by_led) {
      for (std::size_t i = 0; i < fields.size(); ++i) result[i].push_back(std::move(fields[i]));
    }
    return result;
  }

  const std::vector<Field>& fields(const SensorChoice& choice, std::size_t contact) {
    if (choice.grid == 1) return fine_fields(choice.mesh, choice.light, contact);
    auto& resized = meshes_[choice.mesh]->resized[{choice.light, choice.grid}];
    if (resized.empty()) {
      const auto& coarse = coarse_fields(choice.mesh, choice.light, choice.grid);
      for (const auto& one : contacts_) {
        resized.emplace_back();
        for (const Field& field : coarse) {
          resized.back().push_back(
              resized_window(field, meshes_[choice.mesh]->sensor.camera, one.lit()));
        }
      }
    }
    return resized[contact];
  }

  template <std::floating_point T>
  TrialImages images(const SensorChoice& choice, std::size_t contact) {
    const SeenMembrane& there = seen(choice.mesh, contact);
    Image<T> surface = rest_of<T>(there.rest);
    const auto renderer = renderer_of<T>(meshes_[choice.mesh]->sensor, there,
                                         fields(choice, contact), choice, KnownMembrane(surface));
    surface = pressed<T>(choice, contact);
    const Window lit = contacts_[contact].lit_in_window();
    return {renderer.render(rounded<T>(cut_out(contacts_[contact].depth, lit))),
            renderer.rest_image()};
  }

  PlannedLight reference_light_;
  PlannedMembrane reference_membrane_;
  CancelHook cancelled_;
  std::vector<std::unique_ptr<Mesh>> meshes_;  // the reference's, then those to choose from
  double sigma_ = 0, gel_sigma_ = 0;           // pixels: the preset's, and the gel's
  std::vector<TrialContact> contacts_;
  std::vector<TrialImages> references_;
  // By mesh, membrane, sigma, radius and contact.
  template <class T>
  using Surfaces =
      std::map<std::tuple<std::size_t, PlannedMembrane, double, Index, std::size_t>, Image<T>>;
  // By mesh.
  template <class T>
  using Gels = std::map<std::pair<std::size_t, PlannedMembrane>, AnyPlannedMembrane<T>>;
  std::tuple<Surfaces<float>, Surfaces<double>> surfaces_;
  std::tuple<Gels<float>, Gels<double>> gels_;
  std::map<SensorChoice, TrialErrors> errors_;
};

}  // namespace detail
}  // namespace gelight
