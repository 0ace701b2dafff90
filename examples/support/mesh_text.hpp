#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"

// What the files of meshes say that OpenMesh misreads, as OBJ. It leaves a point out that is no
// number and gives its place to the next one, so that every face after it is another; of OFF it
// leaves out the face after a colour or comment; in PLY it takes some properties for others, and
// may go on for ever; and it reads single precision.

/// A mesh file as OBJ.
struct ObjText {
  std::vector<std::array<double, 3>> points;
  /// Its points and faces, and no more.
  std::string lines;
};

namespace mesh_text_detail {

/// What stands between words.
inline constexpr std::string_view word_blanks = " \t\r\v\f\n";

[[nodiscard]] inline std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(word_blanks); at < line.size();) {
    const std::size_t end = std::min(line.find_first_of(word_blanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(word_blanks, end);
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

/// Whether the first ones are numbers, and there are that many.
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

/// What a mesh file that is text says, line by line, without blank ones and comments.
class MeshLines {
 public:
  MeshLines(std::string_view bytes, std::string name, bool has_comments)
      : rest_(bytes), name_(std::move(name)), has_comments_(has_comments) {}

  /// Goes on to the next line; whether there is one.
  bool next() {
    words_.clear();
    while (words_.empty() && !rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      text_ = rest_.substr(0, end);
      if (has_comments_) text_ = text_.substr(0, text_.find('#'));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      words_ = words_of(text_);
      ++number_;
    }
    return !words_.empty();
  }
  [[nodiscard]] std::string_view text() const { return text_; }
  /// What follows the line.
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] std::span<const std::string_view> words() const { return words_; }

  /// Throws InvalidInput, which names the line, where something does not hold.
  template <class... Parts>
  void require(bool holds, const Parts&... parts) const {
    gelight::detail::require(holds, name_, ", line ", number_, ": ", parts...);
  }
  /// That from this word on that many, or all where there are none so many, are numbers.
  void require_numbers(std::size_t first, std::size_t count) const {
    require(are_numbers(words().subspan(first), count), "\"",
            text_.substr(0, text_.find('\r')).substr(0, 60),
            "\": not all are finite numbers up to 3.4e38");
  }
  /// That from this word on they are counts of things, and of no more than the file has bytes.
  void require_counts(std::size_t first, std::size_t bytes) const {
    for (const std::string_view count : words().subspan(first)) {
      require(count.find_first_not_of("0123456789") == count.npos, count,
              " is not a whole number from 0 on");
      require(number_of(count) <= static_cast<double>(bytes), count,
              " things are more than the file's ", bytes, " bytes can be");
    }
  }

 private:
  std::string_view rest_, text_;
  std::string name_;
  bool has_comments_;
  std::size_t number_ = 0;
  std::vector<std::string_view> words_;
};

/// The vertex of a corner such as 7, 7/1, 7//3 or 7/1/3; 0, which is none, for other words.
[[nodiscard]] inline int vertex_of(std::string_view corner) {
  const char* const end = corner.data() + corner.size();
  int vertex = 0, other = 0;
  auto read = std::from_chars(corner.data(), end, vertex);
  if (read.ec != std::errc()) return 0;
  for (int part = 0; part < 2 && read.ptr != end && *read.ptr == '/'; ++part) {
    read = std::from_chars(read.ptr + 1, end, other);  // which may be left out
    if (read.ec == std::errc::result_out_of_range) return 0;
  }
  return read.ptr == end ? vertex : 0;
}

/// Throws InvalidInput for a face of OBJ of which OpenMesh would make another, or none: of fewer
/// than three corners, with one that is no vertex, or with a vertex twice, counted from the last
/// one where it is negative.
inline void require_corners(const MeshLines& line, std::size_t points) {
  const auto corners = line.words().subspan(1);
  line.require(corners.size() >= 3, "the face has ", corners.size(), " corners, not 3 or more");
  std::vector<long long> vertices;
  for (const std::string_view corner : corners) {
    long long vertex = vertex_of(corner);
    line.require(vertex != 0, "the face has the corner \"", corner.substr(0, 60),
                 "\", which is no vertex");
    if (vertex < 0) vertex += static_cast<long long>(points) + 1;
    line.require(std::ranges::find(vertices, vertex) == vertices.end(), "the face has vertex ",
                 vertex, " twice");
    vertices.push_back(vertex);
  }
}

/// What is said of a number of PLY, or of a list of them.
struct PlyProperty {
  std::string_view count, type, name;  // the first: of a list's length, empty where it is none
};
struct PlyElement {
  std::string_view name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

/// Throws InvalidInput for a line of PLY's head, the first of which is 0, that is none.
inline void require_ply_head(const MeshLines& line, std::size_t number, std::size_t bytes) {
  const auto words = line.words();
  const auto is = [](std::string_view word, std::initializer_list<std::string_view> those) {
    return std::ranges::find(those, word) != those.end();
  };
  bool is_known = false;
  if (number == 0) {
    is_known = words.size() == 1 && is(words[0], {"ply", "PLY"});
  } else if (number == 1) {
    is_known = words.size() == 3 && words[0] == "format" && words[2] == "1.0" &&
               is(words[1], {"ascii", "binary_little_endian", "binary_big_endian"});
  } else if (words[0] == "element") {
    is_known = words.size() == 3;
    if (is_known) line.require_counts(2, bytes);
  } else if (words[0] == "property") {
    is_known = words.size() == (words.size() > 1 && words[1] == "list" ? 5 : 3);
  } else if (words[0] == "obj_info") {
    is_known = std::ranges::none_of(words, [&](std::string_view word) {
      return is(word, {"element", "property", "end_header"});
    });
  } else {
    is_known = words[0] == "comment" || (words[0] == "end_header" && words.size() == 1);
  }
  line.require(is_known, "\"", line.text().substr(0, line.text().find('\r')).substr(0, 60),
               "\" is none of the lines of a PLY file's head (ply; format ascii, "
               "binary_little_endian or binary_big_endian 1.0; element; property; end_header)");
}

/// The numbers of a PLY file, one after the other. Throws InvalidInput where there is none.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view bytes, std::string_view format, const std::string& name)
      : rest_(bytes), format_(format), name_(name) {}

  [[nodiscard]] double next(std::string_view type) {
    if (type == "char" || type == "int8") return read<std::int8_t>();
    if (type == "uchar" || type == "uint8") return read<std::uint8_t>();
    if (type == "short" || type == "int16") return read<std::int16_t>();
    if (type == "ushort" || type == "uint16") return read<std::uint16_t>();
    if (type == "int" || type == "int32") return read<std::int32_t>();
    if (type == "uint" || type == "uint32") return read<std::uint32_t>();
    if (type == "float" || type == "float32") return read<float>();
    gelight::detail::require(type == "double" || type == "float64", name_, " has numbers of type ",
                             type, ", which PLY has not");
    return read<double>();
  }

 private:
  template <class Number>
  [[nodiscard]] double read() {
    const bool is_text = format_ == "ascii";
    const std::size_t blanks = is_text ? rest_.find_first_not_of(word_blanks) : 0;
    rest_.remove_prefix(std::min(blanks, rest_.size()));
    const std::size_t size =
        is_text ? std::min(rest_.find_first_of(word_blanks), rest_.size()) : sizeof(Number);
    gelight::detail::require(size > 0 && size <= rest_.size(), name_,
                             " ends before all that its head tells of");
    const std::string_view word = rest_.substr(0, size);
    rest_.remove_prefix(size);
    if (is_text) return number_of(word);
    std::array<char, sizeof(Number)> bytes;
    std::ranges::copy(word, bytes.begin());
    const bool is_native =
        (format_ == "binary_big_endian") == (std::endian::native == std::endian::big);
    if (!is_native) std::ranges::reverse(bytes);
    return static_cast<double>(std::bit_cast<Number>(bytes));
  }

  std::string_view rest_, format_;
  const std::string& name_;
};

/// Adds the point of a vertex, or a face by the numbers of its vertices from 0. Throws InvalidInput
/// for what is none.
///@{
inline void add_point(ObjText& obj, const std::array<double, 3>& point, const std::string& name) {
  const bool is_finite = std::ranges::all_of(
      point, [](double c) { return std::abs(c) <= double{std::numeric_limits<float>::max()}; });
  gelight::detail::require(is_finite, name, ", vertex ", obj.points.size(), " is at (", point[0],
                           ", ", point[1], ", ", point[2],
                           "): not all are finite numbers up to 3.4e38");
  obj.points.push_back(point);
  obj.lines += 'v';
  for (const double c : point) {
    std::array<char, 32> digits;
    obj.lines += ' ';
    obj.lines.append(digits.data(),
                     std::to_chars(digits.data(), digits.data() + digits.size(), c).ptr);
  }
  obj.lines += '\n';
}
inline void add_face(ObjText& obj, const std::vector<double>& vertices, std::size_t face,
                     const std::string& name) {
  gelight::detail::require(vertices.size() >= 3, name, ", face ", face, " has ", vertices.size(),
                           " corners, not 3 or more");
  obj.lines += 'f';
  for (auto v = vertices.begin(); v != vertices.end(); ++v) {
    gelight::detail::require(
        *v >= 0 && *v < static_cast<double>(obj.points.size()) && *v == std::floor(*v), name,
        ", face ", face, " has vertex ", *v, ", of ", obj.points.size());
    gelight::detail::require(std::find(vertices.begin(), v, *v) == v, name, ", face ", face,
                             " has vertex ", *v, " twice");
    obj.lines.append(" ").append(std::to_string(static_cast<long long>(*v) + 1));
  }
  obj.lines += '\n';
}
///@}

/// Adds what a PLY file's numbers say of one vertex, face or other element.
inline void add_element(ObjText& obj, const PlyElement& element, std::size_t number,
                        PlyNumbers& numbers, const std::string& name) {
  const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
  std::array<double, 3> point{};
  std::vector<double> vertices, others;
  std::array<int, 3> told{};  // how often each coordinate is
  for (const auto& [count, type, what] : element.properties) {
    const double size = count.empty() ? 1 : numbers.next(count);
    gelight::detail::require(size >= 0 && size == std::floor(size), name, " has a list of ", size,
                             " numbers");
    const bool is_corners = is_face && (what == "vertex_indices" || what == "vertex_index");
    std::vector<double>& values = is_corners ? vertices : others;
    values.clear();
    for (double i = 0; i < size; ++i) values.push_back(numbers.next(type));
    const std::size_t axis = std::string_view("xyz").find(what);
    if (!is_vertex || !count.empty() || what.size() != 1 || axis >= 3) continue;
    point[axis] = values[0];
    ++told[axis];
  }
  gelight::detail::require(!is_vertex || told == std::array{1, 1, 1}, name,
                           " has vertices without x, y and z, or with one of them twice");
  if (is_vertex) add_point(obj, point, name);
  if (is_face) add_face(obj, vertices, number, name);
}

[[nodiscard]] inline ObjText read_ply(MeshLines line, std::size_t bytes, const std::string& name) {
  std::string_view format;
  std::vector<PlyElement> elements;
  bool is_over = false;
  for (std::size_t number = 0; !is_over && line.next(); ++number) {
    require_ply_head(line, number, bytes);
    const auto words = line.words();
    if (number == 1) format = words[1];
    if (words[0] == "element") {
      elements.push_back({words[1], static_cast<std::size_t>(number_of(words[2])), {}});
    } else if (words[0] == "property") {
      line.require(!elements.empty(), "a property of no element");
      const bool is_list = words.size() == 5;
      elements.back().properties.push_back(
          {is_list ? words[2] : "", words[words.size() - 2], words.back()});
    }
    is_over = words[0] == "end_header";
  }
  gelight::detail::require(is_over, name, ": the head of the PLY file has no end_header");
  PlyNumbers numbers(line.rest(), format, name);
  while (format == "ascii" && line.next()) line.require_numbers(0, line.words().size());
  ObjText obj;
  for (const PlyElement& element : elements) {
    for (std::size_t i = 0; i < element.count; ++i) add_element(obj, element, i, numbers, name);
  }
  return obj;
}

[[nodiscard]] inline ObjText read_off(MeshLines line, std::size_t bytes, const std::string& name) {
  bool is_head = true;
  while (is_head && line.next()) {
    line.require(line.text().find("BINARY") == std::string_view::npos,
                 "OFF of the binary kind is not read; save it as text");
    is_head = line.words()[0].find("OFF") == std::string_view::npos;
  }
  if (is_head) return {};
  // Those of 4OFF are to be divided by a fourth; those of nOFF have any number of coordinates.
  const std::string_view kind = line.words()[0].substr(0, line.words()[0].find("OFF"));
  line.require(kind.find_first_of("4n") == kind.npos,
               "OFF with other points than of three coordinates is not read");
  const std::size_t first = line.words().size() == 1 ? 0 : 1;
  const auto go_on = [&] {
    gelight::detail::require(line.next(), name, " ends before all that its head tells of");
  };
  if (first == 0) go_on();
  line.require_counts(first, bytes);
  line.require(line.words().size() >= first + 2, "no numbers of vertices and faces");
  const auto count = [&](std::size_t i) {
    return static_cast<std::size_t>(number_of(line.words()[first + i]));
  };
  const std::size_t vertices = count(0), faces = count(1);
  ObjText obj;
  for (std::size_t i = 0; i < vertices + faces; ++i) {
    go_on();
    line.require_numbers(0, line.words().size());
    std::vector<double> numbers;
    for (const std::string_view word : line.words()) numbers.push_back(number_of(word));
    if (i < vertices) {
      line.require(numbers.size() >= 3, "a point of ", numbers.size(), " numbers");
      add_point(obj, {numbers[0], numbers[1], numbers[2]}, name);
    } else {
      line.require(numbers[0] >= 0 && numbers[0] < static_cast<double>(numbers.size()) &&
                       numbers[0] == std::floor(numbers[0]),
                   "a face of ", numbers[0], " corners, of which ", numbers.size() - 1, " follow");
      const auto corner = numbers.begin() + 1;
      add_face(obj, {corner, corner + static_cast<std::ptrdiff_t>(numbers[0])}, i - vertices, name);
    }
  }
  gelight::detail::require(!line.next(), name, " goes on after all that its head tells of");
  return obj;
}

inline void require_stl(MeshLines line) {
  while (line.next()) {
    if (line.words()[0] == "vertex") line.require_numbers(1, 3);
  }
}

}  // namespace mesh_text_detail

/// What an OBJ file says, without what follows a #, of which OpenMesh takes numbers for corners.
[[nodiscard]] inline ObjText read_obj(mesh_text_detail::MeshLines line) {
  using mesh_text_detail::number_of;
  ObjText obj;
  while (line.next()) {
    const auto words = line.words();
    if (words[0] == "v") {
      line.require_numbers(1, 3);
      obj.points.push_back({number_of(words[1]), number_of(words[2]), number_of(words[3])});
    } else if (words[0] == "f") {
      mesh_text_detail::require_corners(line, obj.points.size());
    } else {
      continue;
    }
    obj.lines.append(line.text()).push_back('\n');
  }
  return obj;
}

/// What OBJ, OFF and PLY say; nothing of others. Throws InvalidInput, which names the line
/// or what is meant, for a coordinate that is no number, not finite or beyond single precision, for
/// a face of OBJ, PLY or OFF that has fewer than three corners, one that is no vertex or a vertex
/// twice, for an OFF file that is binary, has points of other than three coordinates or is not what
/// its head tells, any but a whole head of PLY, and one that ends too early; the face for a corner
/// that is not finite in binary STL; and for a byte order mark before what is not OBJ.
[[nodiscard]] inline ObjText checked_text(const std::filesystem::path& path) {
  using namespace mesh_text_detail;
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::string name = path.string();
  std::string kind = path.extension().string();
  for (char& c : kind) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  const bool is_obj = kind == ".obj", is_stl = kind == ".stl", is_off = kind == ".off";
  if (is_stl && is_binary_stl(bytes)) {
    require_finite_stl(bytes, name);
    return {};
  }
  if (!is_obj && !is_stl && !is_off && kind != ".ply") return {};
  constexpr std::string_view mark = "\xef\xbb\xbf";
  const bool is_marked = bytes.starts_with(mark);
  gelight::detail::require(is_obj || !is_marked, name,
                           " begins with a byte order mark; save it without one");
  const MeshLines lines(std::string_view(bytes).substr(is_marked ? mark.size() : 0), name,
                        is_obj || is_off);
  if (is_obj) return read_obj(lines);
  if (is_off) return read_off(lines, bytes.size(), name);
  if (kind == ".ply") return read_ply(lines, bytes.size(), name);
  require_stl(lines);
  return {};
}
