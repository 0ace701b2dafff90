#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gelight/core/error.hpp"

// What a mesh file that is text says, line by line: its readers leave out a point that is no number
// and give its place to the next one, so that every face after it is another.

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

/// A number that single precision can hold, as most readers want it.
[[nodiscard]] inline bool is_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  return fault == std::errc() && end == word.data() + word.size() &&
         std::abs(value) <= double{std::numeric_limits<float>::max()};
}

/// Which words of a line have to be numbers, how many at least; none of a line of other things.
struct Numbers {
  std::size_t first = 0, least = 0;
  bool are_all = false;  ///< also those beyond the least
};

[[nodiscard]] inline bool are_numbers(const std::vector<std::string_view>& words,
                                      const Numbers& wanted) {
  const std::size_t last = wanted.are_all ? words.size() : wanted.first + wanted.least;
  if (words.size() < wanted.first + wanted.least) return false;
  for (std::size_t i = wanted.first; i < last; ++i) {
    if (!is_number(words[i])) return false;
  }
  return true;
}

/// Whether the file is STL's binary kind, whose length its 81st to 84th bytes tell.
[[nodiscard]] inline bool is_binary_stl(const std::string& bytes) {
  std::uint32_t faces = 0;
  if (bytes.size() < 84) return false;
  std::memcpy(&faces, bytes.data() + 80, sizeof faces);
  return bytes.size() == 84 + 50 * std::uint64_t{faces};
}

}  // namespace mesh_text_detail

/// Throws InvalidInput, which names the line, where a point of a mesh file that is text (OBJ, OFF,
/// STL, PLY) has a coordinate that is no number, not finite or beyond single precision. Returns how
/// many points an OBJ file has.
inline std::optional<std::size_t> require_points(const std::filesystem::path& path) {
  using namespace mesh_text_detail;
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::string kind = path.extension().string();
  for (char& c : kind) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  const bool is_obj = kind == ".obj", is_off = kind == ".off", is_ply = kind == ".ply";
  if (kind == ".stl" ? is_binary_stl(bytes) : !(is_obj || is_off || is_ply)) return std::nullopt;
  std::size_t points = 0, number = 0;
  bool is_head = is_off || is_ply;
  for (std::string_view rest(bytes); !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    if (is_off) line = line.substr(0, line.find('#'));
    const auto words = words_of(line);
    if (words.empty()) continue;
    if (is_head) {
      if (line.find("binary") != line.npos || line.find("BINARY") != line.npos) return std::nullopt;
      is_head = is_off ? words[0].find("OFF") == line.npos : words[0] != "end_header";
      continue;
    }
    Numbers wanted{};
    if (is_off || is_ply) wanted = {0, 1, true};
    if (is_obj ? words[0] == "v" : words[0] == "vertex") wanted = {1, 3, false};
    gelight::detail::require(are_numbers(words, wanted), path.string(), ", line ", number, ": \"",
                             line.substr(0, 60), "\" is not of numbers alone, or they are too large");
    points += wanted.first;
  }
  if (!is_obj) return std::nullopt;
  return points;
}
