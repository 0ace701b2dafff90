#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"

// What a mesh file that is text says, line by line. OpenMesh leaves a point out that is no number
// and gives its place to the next one, so that every face after it is another; and it reads single
// precision.

namespace mesh_text_detail {

[[nodiscard]] inline std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view blanks = " \t\r\v\f";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(blanks); at < line.size();) {
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(blanks, end);
  }
  return words;
}

/// The number that a word is; NaN for one that single precision cannot hold, as most readers want.
[[nodiscard]] inline double number_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_number = fault == std::errc() && end == word.data() + word.size() &&
                         std::abs(value) <= double{std::numeric_limits<float>::max()};
  return is_number ? value : std::numeric_limits<double>::quiet_NaN();
}

/// Whether these are that many numbers, and at least as many.
[[nodiscard]] inline bool are_numbers(std::span<const std::string_view> words, std::size_t count) {
  return words.size() >= count &&
         std::none_of(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(count),
                      [](std::string_view word) { return std::isnan(number_of(word)); });
}

/// Whether the bytes are STL's binary kind, whose length the 81st to 84th tell.
[[nodiscard]] inline bool is_binary_stl(std::string_view bytes) {
  std::uint32_t faces = 0;
  if (bytes.size() < 84) return false;
  std::memcpy(&faces, bytes.data() + 80, sizeof faces);
  return bytes.size() == 84 + 50 * std::uint64_t{faces};
}

/// Throws InvalidInput, which names the face, for a corner of binary STL that is not finite:
/// OpenMesh takes it for some other point.
inline void require_finite_stl(std::string_view bytes, const std::string& name) {
  for (std::size_t face = 0; 84 + 50 * face < bytes.size(); ++face) {
    std::array<float, 9> corners;  // after the normal
    std::memcpy(corners.data(), bytes.data() + 84 + 50 * face + 12, sizeof corners);
    gelight::detail::require(
        std::all_of(corners.begin(), corners.end(), [](float c) { return std::isfinite(c); }), name,
        ", face ", face, " has a point that is not finite");
  }
}

/// Throws InvalidInput, which names the line, for a face of OBJ that has a vertex twice, counted
/// from the last one where it is negative: OpenMesh leaves it out.
inline void require_other_corners(std::span<const std::string_view> corners, std::size_t points,
                                  const std::string& where) {
  std::vector<long long> vertices;
  for (const std::string_view corner : corners) {
    long long vertex = 0;
    std::from_chars(corner.data(), corner.data() + corner.size(), vertex);
    if (vertex < 0) vertex += static_cast<long long>(points) + 1;
    gelight::detail::require(std::ranges::find(vertices, vertex) == vertices.end(), where,
                             ": the face has vertex ", vertex, " twice");
    vertices.push_back(vertex);
  }
}

/// Throws InvalidInput, which names the line, for a head that tells of more things than the file
/// has bytes: OpenMesh makes room for them.
inline void require_room(std::span<const std::string_view> counts, std::size_t bytes,
                         const std::string& where) {
  for (const std::string_view count : counts) {
    gelight::detail::require(!(number_of(count) > static_cast<double>(bytes)), where, ": ", count,
                             " things are more than the file's ", bytes, " bytes can be");
  }
}

}  // namespace mesh_text_detail

/// The points of an OBJ file, as it has them; none of others. Throws InvalidInput, which names the
/// line, for a coordinate that is no number, not finite or beyond single precision in what of OBJ,
/// OFF, STL and PLY is text, for a face of OBJ with a vertex twice and for a head of OFF or PLY
/// that tells of more than there can be; and the face for one that is not finite in binary STL.
[[nodiscard]] inline std::vector<std::array<double, 3>> points_of_text(
    const std::filesystem::path& path) {
  using namespace mesh_text_detail;
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::string kind = path.extension().string();
  for (char& c : kind) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  const bool is_obj = kind == ".obj", is_stl = kind == ".stl", is_off = kind == ".off";
  std::vector<std::array<double, 3>> points;
  if (is_stl && is_binary_stl(bytes)) {
    require_finite_stl(bytes, path.string());
    return points;
  }
  if (!is_obj && !is_stl && !is_off && kind != ".ply") return points;
  bool is_head = !is_obj && !is_stl, is_binary = false, are_counts_next = false;
  std::size_t number = 0;
  for (std::string_view rest(bytes); !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, is_off ? std::min(end, rest.find('#')) : end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    const auto words = words_of(line);
    if (words.empty()) continue;
    const std::string where = path.string() + ", line " + std::to_string(number);
    if (is_head) {
      if (is_off && line.find("BINARY") != line.npos) return points;
      is_binary = is_binary || line.find("binary") != line.npos;
      is_head = is_off ? words[0].find("OFF") == line.npos : words[0] != "end_header";
      if (is_off && !is_head && words.size() > 1) {
        require_room(std::span(words).subspan(1), bytes.size(), where);
      }
      if (words[0] == "element" && words.size() == 3) {
        require_room(std::span(words).subspan(2), bytes.size(), where);
      }
      are_counts_next = is_off && !is_head && words.size() == 1;
      if (is_binary && !is_head) return points;
      continue;
    }
    if (std::exchange(are_counts_next, false)) require_room(words, bytes.size(), where);
    if (is_obj && words[0] == "f") {
      require_other_corners(std::span(words).subspan(1), points.size(), where);
    }
    const bool is_point = (is_obj && words[0] == "v") || (is_stl && words[0] == "vertex");
    const auto numbers = std::span(words).subspan(is_point ? 1 : 0);
    const std::size_t count = is_point ? 3 : is_obj || is_stl ? 0 : words.size();
    gelight::detail::require(are_numbers(numbers, count), where, ": \"",
                             line.substr(0, line.find('\r')).substr(0, 60),
                             "\": not all are finite numbers up to 3.4e38");
    if (is_obj && is_point) {
      points.push_back({number_of(words[1]), number_of(words[2]), number_of(words[3])});
    }
  }
  return points;
}
