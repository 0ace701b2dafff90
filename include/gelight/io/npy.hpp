#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <istream>
#include <limits>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

namespace detail {

static_assert(std::endian::native == std::endian::little, ".npy files are read as they are");

template <class T>
concept NpyScalar = std::is_arithmetic_v<T> && !std::same_as<T, bool>;

/// NumPy's name of a type, such as <f4.
template <NpyScalar T>
[[nodiscard]] std::string npy_type() {
  const char kind = std::floating_point<T> ? 'f' : std::signed_integral<T> ? 'i' : 'u';
  return std::string(1, sizeof(T) == 1 ? '|' : '<') + kind + std::to_string(sizeof(T));
}

/// A pixel as numbers of one type: itself, a std::array or a fixed-size vector of Eigen's.
template <class P>
struct NpyPixel {
  using Scalar = P;
  static constexpr Index count = 0;  // no dimension of its own
};
template <class S, std::size_t N>
struct NpyPixel<std::array<S, N>> {
  using Scalar = S;
  static constexpr Index count = static_cast<Index>(N);
};
template <class S, int N>
struct NpyPixel<Eigen::Matrix<S, N, 1>> {
  using Scalar = S;
  static constexpr Index count = N;
};

struct NpyHeader {
  std::string type;
  bool column_major = false;
  std::vector<Index> shape;
};

/// What stands behind 'key': in the dictionary of a .npy header.
[[nodiscard]] inline std::string npy_value(const std::string& text, const std::string& key,
                                           const char* last, const std::string& path) {
  const auto at = text.find('\'' + key + "':");
  const auto begin = at == std::string::npos ? at : at + key.size() + 3;
  const auto end = begin == std::string::npos ? begin : text.find_first_of(last, begin);
  require(end != std::string::npos, path, " has no '", key, "' in its .npy header");
  require(text.find('\'' + key + "':", end) == std::string::npos, path, " has '", key,
          "' twice in its .npy header");
  return text.substr(begin, end - begin);
}

/// A text without the blanks around it.
[[nodiscard]] inline std::string npy_word(const std::string& text) {
  const auto first = text.find_first_not_of(' ');
  return first == std::string::npos ? std::string()
                                    : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// Dimensions of a shape as Python writes it, its last bracket apart.
[[nodiscard]] inline std::vector<Index> npy_shape(const std::string& text,
                                                  const std::string& path) {
  const std::string shape = npy_word(text);
  require(shape.starts_with('('), path, " has a 'shape' that is not understood: ", shape, ')');
  std::vector<Index> sizes;
  for (std::size_t begin = 1; begin <= shape.size();) {
    const std::size_t end = std::min(shape.find(',', begin), shape.size());
    const std::string word = npy_word(shape.substr(begin, end - begin));
    begin = end + 1;
    if (word.empty() && end == shape.size()) break;  // behind the last comma, or of ()
    long long n = -1;
    const char* const last = word.data() + word.size();
    const auto read = std::from_chars(word.data(), last, n);
    require(read.ec == std::errc() && read.ptr == last && n >= 0 &&
                n <= std::numeric_limits<Index>::max(),
            path, " has a dimension of ", word.empty() ? "no number" : word);
    sizes.push_back(static_cast<Index>(n));
  }
  return sizes;
}

[[nodiscard]] inline NpyHeader read_npy_header(std::istream& file, const std::string& path) {
  std::array<unsigned char, 8> magic{};
  file.read(reinterpret_cast<char*>(magic.data()), magic.size());
  require(file && std::memcmp(magic.data(), "\x93NUMPY", 6) == 0, path, " is not a .npy file");
  require(magic[6] >= 1 && magic[6] <= 3, path, " has .npy version ", int{magic[6]},
          ", which is not known");
  std::array<unsigned char, 4> size{};
  file.read(reinterpret_cast<char*>(size.data()), magic[6] == 1 ? 2 : 4);
  const std::size_t length = size[0] + (std::size_t{size[1]} << 8) + (std::size_t{size[2]} << 16) +
                             (std::size_t{size[3]} << 24);
  require(file && length < (1u << 20), path, " has a damaged .npy header");
  std::string text(length, ' ');
  file.read(text.data(), static_cast<std::streamsize>(length));
  require(bool(file), path, " ends within its .npy header");

  NpyHeader header;
  const std::string type = npy_value(text, "descr", ",}", path);
  const auto quote = type.find('\'');
  const auto close = type.rfind('\'');
  require(quote != close, path, " has elements of a compound type");
  header.type = type.substr(quote + 1, close - quote - 1);
  const std::string order = npy_word(npy_value(text, "fortran_order", ",}", path));
  header.column_major = order == "True";
  require(header.column_major || order == "False", path,
          " has a 'fortran_order' that is not understood: ", order);
  header.shape = npy_shape(npy_value(text, "shape", ")", path), path);
  return header;
}

[[nodiscard]] inline std::string shape_text(std::span<const Index> shape) {
  std::string text = "(";
  for (const Index n : shape) text += (text.size() > 1 ? ", " : "") + std::to_string(n);
  return text + ")";
}

inline void write_npy_file(const std::string& path, const std::string& type,
                           std::span<const Index> shape, const char* bytes, std::size_t count) {
  std::string sizes = "(";
  for (const Index n : shape) sizes += std::to_string(n) + ",";
  std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + sizes + "), }";
  constexpr std::size_t before = 10;  // magic, version, length
  text.append(63 - (before + text.size()) % 64, ' ');
  text += '\n';
  std::ofstream file(path, std::ios::binary);
  file.write("\x93NUMPY\x01\x00", 8);
  file.put(static_cast<char>(text.size() % 256));
  file.put(static_cast<char>(text.size() / 256));
  file << text;
  file.write(bytes, static_cast<std::streamsize>(count));
  file.flush();
  require(bool(file), path, " cannot be written");
}

/// The bytes of a .npy file whose elements have the size and type of T.
template <NpyScalar T>
[[nodiscard]] std::vector<T> read_npy_values(std::istream& file, const NpyHeader& header,
                                             const std::string& path) {
  std::size_t wanted = sizeof(T);
  for (const Index n : header.shape) {
    constexpr std::size_t most = std::numeric_limits<std::size_t>::max() / 2;
    require(n == 0 || wanted <= most / static_cast<std::size_t>(n), path, " has shape ",
            shape_text(header.shape), ", which is too large");
    wanted *= static_cast<std::size_t>(n);
  }
  const auto begin = file.tellg();
  file.seekg(0, std::ios::end);
  const auto there = static_cast<std::size_t>(file.tellg() - begin);
  file.seekg(begin);
  require(there == wanted, path, " has ", there, " bytes of data where its shape ",
          shape_text(header.shape), " needs ", wanted);
  std::vector<T> values(wanted / sizeof(T));
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(wanted));
  require(bool(file), path, " cannot be read");
  return values;
}

}  // namespace detail

/// Reads an image from NumPy's .npy format: of shape (height, width) for pixels that are numbers,
/// (height, width, n) for pixels that are arrays or vectors of n.
///
/// The elements have the pixel's own type, or are float32 where it is double. Throws InvalidInput
/// where the file is missing, damaged, shorter or longer than its shape says, and where its
/// elements are of another type or big-endian. Both of NumPy's orders are read.
template <class P>
[[nodiscard]] Image<P> read_npy(const std::string& path) {
  using Pixel = detail::NpyPixel<P>;
  using T = typename Pixel::Scalar;
  std::ifstream file(path, std::ios::binary);
  detail::require(bool(file), path, " cannot be opened");
  const detail::NpyHeader header = detail::read_npy_header(file, path);
  const std::string own = detail::npy_type<T>(), narrow = detail::npy_type<float>();
  const bool widen = std::same_as<T, double> && header.type == narrow;
  detail::require(header.type == own || widen, path, " has elements of type ", header.type,
                  ", not ", own, std::same_as<T, double> ? " or " + narrow : std::string());
  const auto& shape = header.shape;
  const bool fits =
      Pixel::count == 0 ? shape.size() == 2 : shape.size() == 3 && shape[2] == Pixel::count;
  detail::require(fits, path, " has shape ", detail::shape_text(shape), ", not (height, width",
                  Pixel::count == 0 ? std::string(")") : ", " + std::to_string(Pixel::count) + ")");

  static_assert(sizeof(P) == sizeof(T) * (Pixel::count == 0 ? 1 : Pixel::count));
  const auto image_of = [&](const auto& values) {
    Image<P> image(shape[1], shape[0]);
    T* const out = reinterpret_cast<T*>(image.data());
    const auto height = static_cast<std::size_t>(shape[0]);
    const auto width = static_cast<std::size_t>(shape[1]);
    const std::size_t channels = Pixel::count == 0 ? 1 : Pixel::count;
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        for (std::size_t c = 0; c < channels; ++c) {
          const std::size_t to = (y * width + x) * channels + c;
          const std::size_t by_columns = (c * width + x) * height + y;
          out[to] = static_cast<T>(values[header.column_major ? by_columns : to]);
        }
      }
    }
    return image;
  };
  if (widen) return image_of(detail::read_npy_values<float>(file, header, path));
  return image_of(detail::read_npy_values<T>(file, header, path));
}

/// Writes an image in NumPy's .npy format, in the shapes that read_npy reads. Throws
/// InvalidInput for a size that is negative or more than Index counts, and where the file cannot be
/// written.
template <ImageLike I>
void write_npy(const std::string& path, const I& image) {
  using P = ImagePixel<I>;
  using Pixel = detail::NpyPixel<P>;
  const auto columns = ImageTraits<I>::width(image);
  const auto rows = ImageTraits<I>::height(image);
  detail::require(std::in_range<Index>(columns) && std::in_range<Index>(rows) &&
                      std::cmp_greater_equal(columns, 0) && std::cmp_greater_equal(rows, 0),
                  "an image of ", columns, " x ", rows, " pixels cannot be written to ", path);
  const auto width = static_cast<Index>(columns), height = static_cast<Index>(rows);
  std::vector<P> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) pixels.push_back(ImageTraits<I>::pixel(image, x, y));
  }
  std::vector<Index> shape{height, width};
  if (Pixel::count > 0) shape.push_back(Pixel::count);
  detail::write_npy_file(path, detail::npy_type<typename Pixel::Scalar>(), shape,
                         reinterpret_cast<const char*>(pixels.data()), pixels.size() * sizeof(P));
}

}  // namespace gelight
