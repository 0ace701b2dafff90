#pragma once

// Opt-in: needs the headers stb_image.h and stb_image_write.h (Debian: libstb-dev) on the include
// path. Their functions are compiled into each translation unit that includes this header, for PNG
// alone and seen nowhere else. A program that uses stb itself does so in other files.

#include <cctype>
#include <climits>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#if defined(__has_include)
#if !__has_include(<stb_image.h>) || !__has_include(<stb_image_write.h>)
#error "gelight/io/image.hpp needs stb: install libstb-dev and compile with -I/usr/include/stb"
#endif
#endif

#if defined(STBI_INCLUDE_STB_IMAGE_H) || defined(INCLUDE_STB_IMAGE_WRITE_H)
#error "gelight/io/image.hpp compiles stb for itself: include no stb_image before it in one file"
#endif

#include "gelight/core/error.hpp"
#include "gelight/views/image_view.hpp"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif
#define STBI_ONLY_PNG
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image.h>
#include <stb_image_write.h>
#undef STB_IMAGE_IMPLEMENTATION
#undef STB_IMAGE_WRITE_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace gelight {

namespace detail {

/// What a function of C gave, given back by another. (Less to compile than std::unique_ptr.)
template <class T, auto give_back>
class Owned {
 public:
  explicit Owned(T* given) : given_(given) {}
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() {
    if (given_ != nullptr) (void)give_back(given_);
  }
  [[nodiscard]] T* get() const { return given_; }

 private:
  T* given_;
};

[[nodiscard, maybe_unused]] static bool begins_as_png(const std::vector<stbi_uc>& bytes) {
  return bytes.size() >= 8 && std::memcmp(bytes.data(), "\x89PNG", 4) == 0;
}

/// All of a file, or, where it is no PNG and may have no end, its first.
[[nodiscard, maybe_unused]] static std::vector<stbi_uc> read_bytes(const std::string& path) {
  const Owned<std::FILE, std::fclose> file(std::fopen(path.c_str(), "rb"));
  require(file.get() != nullptr, path, " cannot be opened");
  std::vector<stbi_uc> bytes;
  stbi_uc block[1 << 14];
  while (const std::size_t read = std::fread(block, 1, sizeof block, file.get())) {
    bytes.insert(bytes.end(), block, block + read);
    require(bytes.size() <= INT_MAX, path, " has more than ", INT_MAX, " bytes");
    if (!begins_as_png(bytes)) break;
  }
  return bytes;
}

/// A chunk of a PNG file: where its data begin, 0 where there is none, and how many they are.
struct PngChunk {
  std::size_t begin = 0, size = 0;
};

[[nodiscard, maybe_unused]] static PngChunk find_chunk(const std::vector<stbi_uc>& png,
                                                       const char* name) {
  for (std::size_t at = 8; at + 8 <= png.size();) {
    std::size_t size = 0;
    for (std::size_t i = at; i < at + 4; ++i) size = size << 8 | png[i];
    if (std::memcmp(&png[at + 4], name, 4) == 0) return {at + 8, size};
    if (size > png.size()) break;
    at += 12 + size;
  }
  return {};
}

/// Why a file is no image: where stb could not read it, or it is cut.
[[nodiscard, maybe_unused]] static const char* fault_of(const std::vector<stbi_uc>& png,
                                                        bool is_read) {
  if (begins_as_png(png)) {
    // Behind the end stb reads zeros, and says that a chunk of their name is not known; that the
    // last chunk's checksum is there, of 4 bytes, it does not look at.
    const std::size_t end = find_chunk(png, "IEND").begin;
    if (end == 0) return "it ends before its chunk IEND";
    if (end + 4 > png.size()) return "it ends within its chunk IEND";
  }
  if (is_read) return nullptr;
  const char* const reason = stbi_failure_reason();  // which stb does not always give
  return reason != nullptr ? reason : "its data are damaged";
}

/// Throws where a file is no whole image.
[[maybe_unused]] static void require_whole(const std::string& path, const std::vector<stbi_uc>& png,
                                           bool is_read) {
  const char* const fault = fault_of(png, is_read);
  require(fault == nullptr, path,
          " is not a PNG image that can be read: ", fault == nullptr ? "" : fault);
}

/// Throws where a pixel is of a colour that is not in the file's list: stb takes what is in memory
/// behind those that are.
[[maybe_unused]] static void require_colours(const std::string& path, std::vector<stbi_uc> png) {
  const std::size_t header = find_chunk(png, "IHDR").begin;
  stbi_uc& kind = png[header + 9];
  const int most = (1 << png[header + 8]) - 1;
  const auto colours = static_cast<int>(find_chunk(png, "PLTE").size / 3);
  if (kind != 3 || colours > most) return;
  kind = 0;  // grey: the numbers of the colours are its levels
  const std::size_t opacity = find_chunk(png, "tRNS").begin;
  if (opacity > 0) png[opacity - 4] = 'x';  // a name that is passed over
  int width = 0, height = 0, channels = 0;
  const Owned<stbi_uc, std::free> levels(stbi_load_from_memory(
      png.data(), static_cast<int>(png.size()), &width, &height, &channels, 1));
  require(levels.get() != nullptr, path, " is not a PNG image whose colours can be told");
  const stbi_uc* level = levels.get();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): stb wrote all levels
      const int colour = *level++ * most / 255;
      require(colour < colours, path, " has colour ", colour, " of ", colours, " at pixel ", x,
              ", ", y);
    }
  }
}

}  // namespace detail

/// Reads a PNG file as 8-bit RGB; grey is repeated, opacity dropped. Throws InvalidInput where the
/// file is missing or is not a whole PNG image, or has a pixel of a colour that it does not list.
/// Checksums are not looked at: damaged bytes may give other pixels.
[[nodiscard, maybe_unused]] static Image<Rgb8> read_png(const std::string& path) {
  const std::vector<stbi_uc> png = detail::read_bytes(path);
  int width = 0, height = 0, channels = 0;
  const detail::Owned<stbi_uc, std::free> pixels(stbi_load_from_memory(
      png.data(), static_cast<int>(png.size()), &width, &height, &channels, 3));
  detail::require_whole(path, png, pixels.get() != nullptr);
  detail::require_colours(path, png);
  Image<Rgb8> image(width, height);
  const stbi_uc* from = pixels.get();
  for (Rgb8& pixel : image.pixels()) {
    pixel = {from[0], from[1], from[2]};
    from += 3;
  }
  return image;
}

/// Reads a grey 16-bit PNG file as a depth map: each value times `unit`, the depth of one step; 0
/// stays 0, which is not known. Throws InvalidInput for a unit that is not positive and finite, or
/// makes a depth that is not, and where the file is missing, is not a whole PNG image, or is in
/// colour or in 8 bits. Checksums are not looked at: damaged bytes may give other depths.
template <std::floating_point T>
[[nodiscard]] static Image<T> read_depth_png(const std::string& path, T unit) {
  detail::require(unit > 0 && std::isfinite(unit), "a depth map in a unit of ", unit);
  const std::vector<stbi_uc> png = detail::read_bytes(path);
  const auto size = static_cast<int>(png.size());
  int width = 0, height = 0, channels = 0;
  const bool is_image = stbi_info_from_memory(png.data(), size, &width, &height, &channels) != 0;
  detail::require_whole(path, png, is_image);
  detail::require(channels == 1, path, " has ", channels, " channels, a depth map has one");
  detail::require(stbi_is_16_bit_from_memory(png.data(), size) != 0, path,
                  " has 8 bits a channel, a depth map has 16");
  const detail::Owned<stbi_us, std::free> values(
      stbi_load_16_from_memory(png.data(), size, &width, &height, &channels, 1));
  detail::require_whole(path, png, values.get() != nullptr);
  Image<T> depth(width, height);
  const stbi_us* from = values.get();
  for (T& z : depth.pixels()) {
    z = static_cast<T>(*from++) * unit;
    detail::require(std::isfinite(z), path, " has a value of which ", unit, " makes ", z);
  }
  return depth;
}

/// Writes an image as an 8-bit RGB PNG file. Throws InvalidInput for an image without pixels or of
/// more than a GiB of them, for a name with the ending of another image format, and where the file
/// cannot be written.
[[maybe_unused]] static void write_png(const std::string& path, ImageView<const Rgb8> image) {
  detail::require(image.width() > 0 && image.height() > 0, "an image of ", image.width(), " x ",
                  image.height(), " pixels cannot be written to ", path);
  // stb counts bytes, one a row more than pixels have, in an int, and lets memory grow by doubling.
  constexpr std::int64_t most_bytes = std::int64_t{1} << 30;
  const std::int64_t bytes_a_row = 3 * std::int64_t{image.width()} + 1;
  detail::require(bytes_a_row <= most_bytes / image.height(), "an image of ", image.width(), " x ",
                  image.height(), " pixels is too large to be written to ", path);
  const std::size_t dot = path.find_last_of("./");
  std::string ending = dot == std::string::npos ? "" : path.substr(dot);
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* other : {".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff", ".webp", ".ppm"}) {
    detail::require(ending != other, path, " would be a PNG file; let its name end in .png");
  }
  Image<Rgb8> packed(image.width(), image.height());
  for (Index y = 0; y < image.height(); ++y) {
    for (Index x = 0; x < image.width(); ++x) packed(x, y) = image(x, y);
  }
  // stb's own writer of files does not notice a full disk.
  int size = 0;
  const detail::Owned<stbi_uc, std::free> png(stbi_write_png_to_mem(
      packed.data()->data(), 3 * image.width(), image.width(), image.height(), 3, &size));
  const auto bytes = static_cast<std::size_t>(size);
  std::FILE* const file = png.get() != nullptr ? std::fopen(path.c_str(), "wb") : nullptr;
  const bool is_written = file != nullptr && std::fwrite(png.get(), 1, bytes, file) == bytes;
  const bool is_closed = file != nullptr && std::fclose(file) == 0;
  detail::require(is_written && is_closed, path, " cannot be written");
}

}  // namespace gelight
