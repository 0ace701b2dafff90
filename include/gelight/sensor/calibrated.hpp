#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <istream>
#include <limits>
#include <locale>
#include <memory>
#include <ostream>
#include <string>
#include <variant>
#include <vector>

#include "gelight/concepts/reflectance.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/shading/fitted.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A sensor as it was calibrated: what a file keeps and a renderer needs.
struct CalibratedSensor {
  Image<Rgb8> background;         ///< the photograph of the untouched gel
  FittedReflectance reflectance;  ///< fitted to flat gel: normals are those of the camera's frame
  double bulge_length = 0;        ///< of a TensionMembrane, pixels
  /// By how many grey levels photographs of presses are brighter all over, the median: some cameras
  /// balance their colours anew. Not rendered.
  Change level{};
};

/// The reflectance of a calibrated sensor for TactileRenderer: background * (1 + change), bilinear
/// in a table of the normal, quadratic in the place. (16-byte nodes of a row's own, from which a
/// pixel reads twelve.)
///
/// Lights and polynomials are tabulated first, with `nodes` along each coordinate of the normal.
template <std::floating_point T>
class CalibratedReflectance {
 public:
  /// The renderer tells which pixels an object touches.
  static constexpr bool reads_touched = true;

  /// Throws InvalidInput for a background of less than 2 x 2 pixels, for a reach by which T does
  /// not hold half of the nodes, for numbers of which T does not hold 4096 times as much, and as
  /// `tabulated` does.
  explicit CalibratedReflectance(const CalibratedSensor& sensor, int nodes = 17)
      : shared_(std::make_shared<const Rows>(sensor.background,
                                             tabulated(sensor.reflectance, nodes))) {}

  /// Throws InvalidInput for a camera of another size than the background's.
  void require_fits(const Camera<T>& camera) const {
    const Rows& rows = *shared_;
    detail::require(camera.width == rows.width && camera.height == rows.height, "the camera has ",
                    camera.width, " x ", camera.height, " pixels, the calibrated background ",
                    rows.width, " x ", rows.height);
  }

  /// As concepts/reflectance.hpp says.
  void shade_row(const ColourRow<T>& out, const SurfaceRow<T>& row) const {
    const Rows& rows = *shared_;
    std::array<std::int32_t, longest_surface_row> cell;
    std::array<T, longest_surface_row> f, g;
    constexpr T half_level = T(0.5 / 255);
    const T scale = rows.scale, middle = rows.middle, last = rows.last;
    const std::int32_t nodes = rows.nodes;
    for (std::ptrdiff_t i = 0; i < row.count; ++i) {
      const T u = std::min(last, std::max(T(0), row.nx[i] * scale + middle));
      const T v = std::min(last, std::max(T(0), row.ny[i] * scale + middle));
      const auto a = static_cast<std::int32_t>(u), b = static_cast<std::int32_t>(v);
      f[static_cast<std::size_t>(i)] = u - static_cast<T>(a);
      g[static_cast<std::size_t>(i)] = v - static_cast<T>(b);
      cell[static_cast<std::size_t>(i)] = b * nodes + a;
    }
    const std::ptrdiff_t table = rows.table_size();
    const T* const cells = rows.tables.data() + std::ptrdiff_t{row.y} * 2 * table;
    const T* const places = rows.places.data() + row.x;
    std::array<T, 8 * longest_surface_row> mixed;  // of a node and of its neighbour, of each pixel
    for (std::ptrdiff_t i = 0; i < row.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const bool touched = row.touched != nullptr && row.touched[i] != 0;
      const T* __restrict const upper =
          cells + (touched ? table : 0) + std::ptrdiff_t{cell[at]} * numbers;
      const T* __restrict const lower = upper + std::ptrdiff_t{nodes} * numbers;
      const T down = g[at], x = places[i];
      T* __restrict const to = mixed.data() + 8 * i;
      for (std::size_t k = 0; k < 8; ++k) {
        const T above = upper[k] + x * (upper[8 + k] + x * upper[16 + k]);
        const T below = lower[k] + x * (lower[8 + k] + x * lower[16 + k]);
        to[k] = above + down * (below - above);
      }
    }
    const T* background = rows.background.data() + 4 * (std::ptrdiff_t{row.y} * rows.width + row.x);
    for (std::ptrdiff_t i = 0; i < row.count; ++i, background += 4) {
      const T* const of_pixel = mixed.data() + 8 * i;
      const T right = f[static_cast<std::size_t>(i)];
      // Where there is no normal, the light is as it was.
      const bool is_surface = (row.nx[i] != 0) | (row.ny[i] != 0) | (row.nz[i] != 0);
      std::array<T, 4> colour;
      for (std::size_t k = 0; k < 4; ++k) {
        const T change = of_pixel[k] + right * (of_pixel[4 + k] - of_pixel[k]);
        colour[k] = background[k] * (1 + (is_surface ? change : 0)) + half_level;
      }
      out.r[i] = colour[0];
      out.g[i] = colour[1];
      out.b[i] = colour[2];
    }
  }

 private:
  // Of a node and then of its right neighbour red, green, blue and nothing; this for x^0, x^1, x^2.
  static constexpr std::ptrdiff_t numbers = 24;

  struct Rows {
    Index width, height;
    std::int32_t nodes;
    T scale, middle, last;
    std::vector<T> places;  // of each column, -1 to 1
    std::vector<T> tables, background;

    [[nodiscard]] std::ptrdiff_t table_size() const {
      return std::ptrdiff_t{nodes} * nodes * numbers;
    }

    Rows(const Image<Rgb8>& image, const TableReflectance& table)
        : width(image.width()),
          height(image.height()),
          nodes(table.nodes),
          scale(static_cast<T>((table.nodes - 1) / (2 * table.reach))),
          middle(static_cast<T>((table.nodes - 1) / 2.0)),
          last(std::nextafter(static_cast<T>(table.nodes - 1), T(0))) {
      detail::require(width > 1 && height > 1, "a calibrated background of ", width, " x ", height,
                      " pixels");
      require_held(table);
      for (Index x = 0; x < width; ++x) places.push_back(static_cast<T>(2.0 * x / (width - 1) - 1));
      background.reserve(4 * image.pixels().size());
      for (const Rgb8& pixel : image.pixels()) {
        for (const std::uint8_t level : pixel) background.push_back(static_cast<T>(level / 255.0));
        background.push_back(0);
      }
      tables.resize(static_cast<std::size_t>(2 * table_size() * height));
      for (Index y = 0; y < height; ++y) fold(table, y);
    }

    // A sum of a node's terms, in grey levels, is infinite in T otherwise, and may be no number.
    static void require_held(const TableReflectance& table) {
      const auto most = static_cast<double>(std::numeric_limits<T>::max());
      detail::require((table.nodes - 1) / (2 * table.reach) <= most, "a table of reach ",
                      table.reach, ", too little to divide by");
      for (const std::vector<double>* const part : {&table.touched, &table.free}) {
        for (std::size_t i = 0; i < part->size(); ++i) {
          detail::require(std::abs((*part)[i]) <= most / 4096, "number ", i, " of the table of ",
                          part == &table.free ? "free" : "touched", " gel is ", (*part)[i],
                          ", more than the images' type can hold");
        }
      }
    }

    // The table at row y, for free gel and then for touched.
    void fold(const TableReflectance& table, Index y) {
      const double v = 2.0 * y / (height - 1) - 1;
      T* out = tables.data() + std::ptrdiff_t{y} * 2 * table_size();
      for (const std::vector<double>* const part : {&table.free, &table.touched}) {
        for (int node = 0; node < nodes * nodes; ++node, out += numbers) {
          for (const int beside : {0, 1}) {
            const int at = std::min(node + beside, nodes * nodes - 1);
            const double* const k = part->data() + std::ptrdiff_t{at} * detail::place_terms * 3;
            T* const to = out + std::ptrdiff_t{4} * beside;
            for (std::ptrdiff_t c = 0; c < 3; ++c) {
              to[c] = static_cast<T>(k[c] + v * (k[6 + c] + v * k[15 + c]));
              to[8 + c] = static_cast<T>(k[3 + c] + v * k[12 + c]);
              to[16 + c] = static_cast<T>(k[9 + c]);
            }
          }
        }
      }
    }
  };

  std::shared_ptr<const Rows> shared_;  // copies of a reflectance read the same tables
};

// --- files -------------------------------------------------------------------------------------

namespace detail {

inline constexpr const char* sensor_magic = "gelight-sensor-1";
inline constexpr Index widest_background = 16384;

inline void write_numbers(std::ostream& out, const std::vector<double>& numbers) {
  out << numbers.size();
  for (const double number : numbers) out << ' ' << number;
  out << '\n';
}
inline void write_model(std::ostream& out, const TableReflectance& m) {
  out << "table " << m.nodes << ' ' << m.reach << '\n';
  write_numbers(out, m.touched);
  write_numbers(out, m.free);
}
inline void write_model(std::ostream& out, const PolynomialReflectance& m) {
  out << "polynomial " << m.degree << ' ' << m.reach << '\n';
  write_numbers(out, m.touched);
  write_numbers(out, m.free);
}
inline void write_model(std::ostream& out, const LightsReflectance& m) {
  out << "lights " << m.lights.size() << ' ' << m.height << '\n';
  std::vector<double> numbers{m.softness, m.falloff, m.shininess};
  for (const Change& three : {m.ambient, m.contact, m.free_share}) {
    numbers.insert(numbers.end(), three.begin(), three.end());
  }
  for (const NearLight& light : m.lights) {
    numbers.insert(numbers.end(), {light.place.x(), light.place.y(), light.place.z()});
    numbers.insert(numbers.end(), light.diffuse.begin(), light.diffuse.end());
    numbers.insert(numbers.end(), light.specular.begin(), light.specular.end());
  }
  write_numbers(out, numbers);
}

[[nodiscard]] inline std::vector<double> read_numbers(std::istream& in, std::size_t wanted,
                                                      const std::string& path) {
  std::size_t count = 0;
  in >> count;
  require(in.good() && count == wanted, path, " has ", count, " numbers where ", wanted,
          " are wanted");
  std::vector<double> numbers(count);
  for (double& number : numbers) in >> number;
  require(in.good(), path, " ends within its numbers, or has something else among them");
  for (const double number : numbers)
    require(std::isfinite(number), path, " has a number ", number);
  return numbers;
}

template <class Model>
[[nodiscard]] Model read_linear(std::istream& in, Model model, const std::string& path) {
  require(model.reach > 0 && model.reach <= 1, path, " has reach ", model.reach, ", not in (0, 1]");
  const std::size_t wanted = 3 * static_cast<std::size_t>(model.size());
  model.touched = read_numbers(in, wanted, path);
  model.free = read_numbers(in, wanted, path);
  return model;
}

[[nodiscard]] inline LightsReflectance read_lights(std::istream& in, int count, double height,
                                                   const std::string& path) {
  const auto numbers = read_numbers(in, 12 + 9 * static_cast<std::size_t>(count), path);
  LightsReflectance m;
  const double* next = numbers.data();
  const auto three = [&](Change& to) {
    for (double& value : to) value = *next++;
  };
  m.height = height;
  m.softness = *next++;
  m.falloff = *next++;
  m.shininess = *next++;
  require(m.softness > 0 && m.shininess > 0, path, " has softness ", m.softness, " and shininess ",
          m.shininess, ", which are not both positive");
  three(m.ambient);
  three(m.contact);
  three(m.free_share);
  m.lights.resize(static_cast<std::size_t>(count));
  for (NearLight& light : m.lights) {
    for (int axis = 0; axis < 3; ++axis) light.place[axis] = *next++;
    three(light.diffuse);
    three(light.specular);
  }
  return m;
}

[[nodiscard]] inline FittedReflectance read_model(std::istream& in, const std::string& path) {
  std::string kind;
  int count = 0;
  double number = 0;
  in >> kind >> count >> number;
  const int fewest = kind == "lights" ? 0 : 1;
  require(in.good() && count >= fewest && count <= 65 && std::isfinite(number) && number > 0, path,
          " does not tell a reflectance");
  if (kind == "lights") return read_lights(in, count, number, path);
  if (kind == "polynomial")
    return read_linear(in, PolynomialReflectance{count, number, {}, {}}, path);
  require(kind == "table" && count >= 3, path, " has a reflectance of an unknown kind, ", kind);
  return read_linear(in, TableReflectance{count, number, {}, {}}, path);
}

}  // namespace detail

namespace detail {

inline void require_sensor(const CalibratedSensor& sensor) {
  require_reflectance(sensor.reflectance);
  const Index width = sensor.background.width(), height = sensor.background.height();
  require(width > 1 && height > 1 && width <= widest_background && height <= widest_background,
          "a calibrated background of ", width, " x ", height, " pixels");
  require(sensor.bulge_length >= 0 && std::isfinite(sensor.bulge_length), "a bulge of ",
          sensor.bulge_length, " pixels");
  for (const double level : sensor.level) {
    require(std::isfinite(level), "photographs brighter by ", level, " grey levels");
  }
}

}  // namespace detail

/// Writes a calibrated sensor to one file: numbers as text, in as many digits as bring them back to
/// the last bit, then the background as a binary PPM. Throws InvalidInput for what read_sensor
/// would not read, before anything is written, and where the file cannot be written.
inline void write_sensor(const std::string& path, const CalibratedSensor& sensor) {
  detail::require_sensor(sensor);
  std::ofstream out(path, std::ios::binary);
  out.imbue(std::locale::classic());
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << detail::sensor_magic
      << '\n'
      << sensor.bulge_length << ' ' << sensor.level[0] << ' ' << sensor.level[1] << ' '
      << sensor.level[2] << '\n';
  std::visit([&](const auto& model) { detail::write_model(out, model); }, sensor.reflectance);
  out << "P6 " << sensor.background.width() << ' ' << sensor.background.height() << " 255\n";
  for (const Rgb8& pixel : sensor.background.pixels()) {
    for (const std::uint8_t level : pixel) out.put(static_cast<char>(level));
  }
  out.flush();
  detail::require(out.good(), path, " cannot be written");
}

/// Reads a sensor that write_sensor wrote. Throws InvalidInput, naming the file and what is wrong
/// with it.
[[nodiscard]] inline CalibratedSensor read_sensor(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  detail::require(in.good(), path, " cannot be opened");
  in.imbue(std::locale::classic());
  std::string magic;
  in >> magic;
  detail::require(magic == detail::sensor_magic, path, " is not a calibrated sensor");
  CalibratedSensor sensor;
  in >> sensor.bulge_length >> sensor.level[0] >> sensor.level[1] >> sensor.level[2];
  detail::require(in.good() && sensor.bulge_length >= 0 && std::isfinite(sensor.bulge_length), path,
                  " has no bulge length");
  sensor.reflectance = detail::read_model(in, path);
  std::string kind;
  Index width = 0, height = 0;
  int most = 0;
  in >> kind >> width >> height >> most;
  detail::require(in.good() && kind == "P6" && most == 255 && width > 1 && height > 1 &&
                      width <= detail::widest_background && height <= detail::widest_background,
                  path, " has no background image");
  in.get();
  Image<Rgb8> background(width, height);
  for (Rgb8& pixel : background.pixels()) {
    for (std::uint8_t& level : pixel) level = static_cast<std::uint8_t>(in.get());
  }
  detail::require(in.good(), path, " ends within its background image");
  sensor.background = std::move(background);
  return sensor;
}

}  // namespace gelight
