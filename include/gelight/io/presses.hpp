#pragma once

// Opt-in as io/image.hpp is: needs stb's headers.

#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>
#include <string>
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

/// Reads a folder that holds background.png, photographs, and presses.csv with a line of names
/// and then, for each photograph, image, center_x_px, center_y_px, contact_radius_px,
/// ball_radius_mm, mm_per_px; the three of the circle may be empty where it is not known.
/// Throws InvalidInput, naming file and line, for what is missing or not a number, and as read_png
/// does.
[[nodiscard, maybe_unused]] static PressFolder read_presses(const std::string& folder) {
  PressFolder all;
  all.background = read_png(folder + "/background.png");
  const std::string path = folder + "/presses.csv";
  std::ifstream file(path);
  detail::require(file.good(), path, " cannot be opened");
  std::string line;
  std::getline(file, line);
  for (int number = 2; std::getline(file, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    detail::require(cells.size() == 6, path, " line ", number, " has ", cells.size(),
                    " values, not 6");
    const auto value = [&](std::size_t column) {
      if (cells[column].empty() && column <= 3) return 0.0;
      std::istringstream digits(cells[column]);
      digits.imbue(std::locale::classic());  // whatever the user's own decimal point
      double read = 0;
      const bool is_number = bool(digits >> read) && digits.eof() && std::isfinite(read);
      detail::require(is_number, path, " line ", number, " has ", cells[column],
                      " where a number is wanted");
      return read;
    };
    const double scale = value(5);
    detail::require(scale > 0, path, " line ", number, " has ", scale, " mm a pixel");
    all.presses.push_back({cells[0],
                           read_png(folder + "/" + cells[0]),
                           {value(1), value(2), value(3)},
                           value(4) / scale});
  }
  return all;
}

}  // namespace gelight
