#pragma once

// Opt-in as io/image.hpp is: needs stb's headers.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <locale>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/io/image.hpp"
#include "gelight/sensor/calibrate.hpp"

namespace gelight {

/// Photographs of presses of a ball, and of the sensor untouched.
struct PressFolder {
  /// The photograph without contact.
  Image<Rgb8> background;
  /// The presses, one a photograph.
  std::vector<BallPress> presses;
};

namespace detail {

/// A line's cells, without the blanks around them.
[[nodiscard, maybe_unused]] static std::vector<std::string> cells_of(std::string line) {
  std::vector<std::string> cells;
  line.push_back(',');
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) {
    const std::size_t first = cell.find_first_not_of(" \t\r");
    const std::size_t last = cell.find_last_not_of(" \t\r");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

/// presses.csv: which column is which, and what its lines say.
class PressTable {
 public:
  static constexpr std::array<const char*, 6> names{
      "image", "center_x_px", "center_y_px", "contact_radius_px", "ball_radius_mm", "mm_per_px"};

  PressTable(std::string path, std::string header) : path_(std::move(path)) {
    if (header.starts_with("\xef\xbb\xbf")) header.erase(0, 3);  // spreadsheets mark UTF-8 so
    const std::vector<std::string> found = cells_of(header);
    columns_ = found.size();
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto at = std::find(found.begin(), found.end(), names[k]);
      require(at != found.end(), path_, " line 1 has no column ", names[k]);
      column_[k] = static_cast<std::size_t>(at - found.begin());
    }
  }

  void start_line(const std::string& line, int number) {
    place_ = joined(path_, " line ", number);
    cells_ = cells_of(line);
    require(cells_.size() == columns_, place_, " has ", cells_.size(), " values, not ", columns_);
  }

  [[nodiscard]] const std::string& image() const {
    const std::string& name = cells_[column_[0]];
    require(!name.empty(), place_, " names no image");
    return name;
  }
  /// All three numbers, or 0 where none of them is given.
  [[nodiscard]] Circle circle() const {
    int given = 0;
    for (std::size_t k = 1; k <= 3; ++k) given += cells_[column_[k]].empty() ? 0 : 1;
    if (given == 0) return {};
    const Circle read{number(1), number(2), number(3)};
    require(read.radius > 0, place_, " has contact_radius_px ", read.radius,
            ", which is not positive");
    return read;
  }
  /// In pixels.
  [[nodiscard]] double ball_radius() const {
    const double radius = positive(4), pixel = positive(5), read = radius / pixel;
    require(read > 0 && std::isfinite(read), place_, " has ", names[4], " ", radius, " and ",
            names[5], " ", pixel, ": a ball of ", read, " pixels");
    return read;
  }

 private:
  [[nodiscard]] double positive(std::size_t k) const {
    const double read = number(k);
    require(read > 0, place_, " has ", names[k], " ", read, ", which is not positive");
    return read;
  }
  [[nodiscard]] double number(std::size_t k) const {
    const std::string& cell = cells_[column_[k]];
    require(!cell.empty(), place_, " has no ", names[k]);
    std::istringstream digits(cell);
    digits.imbue(std::locale::classic());  // whatever the user's own decimal point
    double read = 0;
    const bool is_number = bool(digits >> read) && digits.eof() && std::isfinite(read);
    require(is_number, place_, " has ", cell, " for ", names[k], ", where a number is wanted");
    return read;
  }

  std::string path_, place_;
  std::size_t columns_ = 0;
  std::array<std::size_t, 6> column_{};
  std::vector<std::string> cells_;
};

}  // namespace detail

/// Reads a folder that holds background.png, photographs, and presses.csv with a line of names and
/// then a line for each photograph: image, center_x_px, center_y_px, contact_radius_px,
/// ball_radius_mm, mm_per_px, in any order and among others; the three of the circle may be empty
/// where it is not known. Throws InvalidInput, naming file and line, for what is missing or not a
/// number, a ball of no size in pixels and a table without presses, and as read_png does.
[[nodiscard, maybe_unused]] static PressFolder read_presses(const std::string& folder) {
  PressFolder all;
  all.background = read_png(folder + "/background.png");
  const std::string path = folder + "/presses.csv";
  std::ifstream file(path);
  detail::require(file.good(), path, " cannot be opened");
  std::string line;
  std::getline(file, line);
  detail::PressTable table(path, line);
  for (int number = 2; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    table.start_line(line, number);
    const Circle circle = table.circle();
    const double ball = table.ball_radius();
    all.presses.push_back({table.image(), read_png(folder + "/" + table.image()), circle, ball});
  }
  detail::require(!all.presses.empty(), path, " has no line of a press after line 1");
  return all;
}

}  // namespace gelight
