// How much two datasets look alike, as Table I of the GelTip simulation paper tells it: SSIM, PSNR
// and mean absolute error of sample i of the one and sample i of the other, over each kind of
// sensor.
//
// similarity a.h5 b.h5 [--picture out.png]. Of one scene with two kinds of light, say: the poses of
// sample i depend on the seed and i alone.

#include "gelight/image/similarity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "../support/command_line.hpp"
#include "../support/durable_file.hpp"
#include "../support/figure.hpp"
#include "../support/hdf5.hpp"
#include "gelight/core/parallel.hpp"

namespace {

using Picture = gelight::Image<gelight::Rgb8>;

/// What is measured of a pair: SSIM, PSNR (dB), mean absolute error (levels).
struct Likeness {
  std::int32_t sensor = 0;
  std::array<double, 3> values{};
  bool is_of_one_press = true;
};

Picture image_of(const hdf5::ReadFile& file, hsize_t row) {
  const auto shape = file.shape("image");
  const auto levels = file.row<std::uint8_t>("image", row);
  Picture image(static_cast<gelight::Index>(shape[2]), static_cast<gelight::Index>(shape[1]));
  for (std::size_t p = 0; p < image.pixels().size(); ++p) {
    image.pixels()[p] = {levels[3 * p], levels[3 * p + 1], levels[3 * p + 2]};
  }
  return image;
}

Picture difference(const Picture& a, const Picture& b) {
  Picture result(a.width(), a.height());
  for (std::size_t p = 0; p < a.pixels().size(); ++p) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int twice = 2 * std::abs(a.pixels()[p][c] - b.pixels()[p][c]);
      result.pixels()[p][c] = static_cast<std::uint8_t>(std::min(255, twice));
    }
  }
  return result;
}

Likeness likeness(const Picture& a, const Picture& b) {
  double sum = 0;
  for (std::size_t p = 0; p < a.pixels().size(); ++p) {
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(a.pixels()[p][c] - b.pixels()[p][c]);
  }
  const double numbers = 3 * static_cast<double>(a.pixels().size());
  return {.values = {gelight::ssim(a, b), gelight::psnr(a, b), sum / numbers}};
}

/// A text's lines, of which some or all may be empty.
std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all(1);
  for (const char c : text) {
    if (c == '\n') {
      all.emplace_back();
    } else {
      all.back() += c;
    }
  }
  return all;
}

/// How large a set of images is, in words.
std::string size_of(const hdf5::ReadFile& file) {
  const auto shape = file.shape("image");
  return std::to_string(shape[0]) + " images of " + std::to_string(shape[2]) + " x " +
         std::to_string(shape[1]);
}

/// What is pressed and where: the object's name; depth and shifts; place, size and turns.
std::pair<std::string, std::vector<double>> press_of(const hdf5::ReadFile& file,
                                                     const std::vector<std::string>& objects,
                                                     hsize_t row) {
  auto numbers = file.row<double>("press", row);
  numbers.pop_back();  // the gel's modulus, which no image shows
  const auto place = file.row<double>("place", row);
  numbers.insert(numbers.end(), place.begin(), place.end());
  const auto object = file.row<std::int32_t>("object", row)[0];
  return {objects.at(static_cast<std::size_t>(object)), numbers};
}

/// Mean and standard deviation of one value where it is finite, of one kind of sensor; -1: of all.
std::string mean_of(const std::vector<Likeness>& all, std::int32_t sensor, std::size_t value) {
  double pairs = 0, count = 0, sum = 0, squares = 0;
  for (const Likeness& pair : all) {
    if (sensor >= 0 && pair.sensor != sensor) continue;
    ++pairs;
    if (!std::isfinite(pair.values[value])) continue;
    ++count;
    sum += pair.values[value];
    squares += pair.values[value] * pair.values[value];
  }
  if (pairs == 0) return "no images";
  if (count == 0) return "equal";
  const double mean = sum / count;
  char text[64];
  std::snprintf(text, sizeof text, "%.3f +- %.3f", mean,
                std::sqrt(std::max(0.0, squares / count - mean * mean)));
  return text;
}

void print(const std::vector<Likeness>& all, const std::vector<std::string>& sensors) {
  std::printf("| %-28s | %-18s | %-18s | %-18s |\n|---|---|---|---|\n", "sensor", "SSIM",
              "PSNR [dB] *", "MAE [levels]");
  for (std::int32_t s = -1; s < static_cast<std::int32_t>(sensors.size()); ++s) {
    std::printf("| %-28s |", s < 0 ? "all" : sensors[static_cast<std::size_t>(s)].c_str());
    for (std::size_t v = 0; v < 3; ++v) std::printf(" %-18s |", mean_of(all, s, v).c_str());
    std::printf("\n");
  }
  std::printf("* of those that differ\n");
  const auto others = std::count_if(all.begin(), all.end(),
                                    [](const Likeness& pair) { return !pair.is_of_one_press; });
  if (others == 0) return;
  std::printf("! in %td of %zu pairs what is pressed, where or how deep differs too\n", others,
              all.size());
}

/// Six pairs, from the least alike to the most, and twice their difference.
void draw(const std::string& path, const hdf5::ReadFile& a, const hdf5::ReadFile& b,
          const std::vector<Likeness>& all) {
  std::vector<std::size_t> order(all.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return all[i].values[0] < all[j].values[0]; });
  const auto shape = a.shape("image");
  const double width = 240, scale = width / static_cast<double>(shape[2]);
  const double height = scale * static_cast<double>(shape[1]), gap = 6, head = 26;
  const std::size_t rows = std::min<std::size_t>(6, order.size());
  Figure figure(static_cast<int>(3 * (width + gap) + gap),
                static_cast<int>(static_cast<double>(rows) * (height + head) + head));
  const char* const names[] = {"one", "the other", "twice the difference"};
  for (std::size_t c = 0; c < 3; ++c) {
    figure.text(names[c], gap + (static_cast<double>(c) + 0.5) * (width + gap), head / 2, 14);
  }
  for (std::size_t r = 0; r < rows; ++r) {
    const std::size_t i = order[rows == 1 ? 0 : r * (order.size() - 1) / (rows - 1)];
    const Picture one = image_of(a, i), other = image_of(b, i);
    const double y = head + static_cast<double>(r) * (height + head);
    figure.image(one, gap, y, scale);
    figure.image(other, 2 * gap + width, y, scale);
    figure.image(difference(one, other), 3 * gap + 2 * width, y, scale);
    char words[96];
    std::snprintf(words, sizeof words, "sample %zu: SSIM %.3f, PSNR %.1f dB, MAE %.2f levels", i,
                  all[i].values[0], all[i].values[1], all[i].values[2]);
    figure.text_from(words, gap, y + height + head / 2, 13);
  }
  figure.save(path);
}

void compare(const std::string& one, const std::string& other, const std::string& picture) {
  const hdf5::ReadFile a(one), b(other);
  if (a.shape("image") != b.shape("image")) {
    throw std::runtime_error(one + " has " + size_of(a) + " pixels, " + other + " has " +
                             size_of(b) + ": only as many of one size can be compared");
  }
  if (!picture.empty()) {
    const auto folder = durable_detail::folder_of(picture);
    if (!std::filesystem::is_directory(folder)) {
      throw std::runtime_error("there is no folder " + folder.string() + " for " + picture);
    }
  }
  const auto objects = lines(a.attribute("objects")), objects_of_b = lines(b.attribute("objects"));
  std::vector<Likeness> all(a.shape("image")[0]);
  gelight::parallel_for(static_cast<gelight::Index>(all.size()), 0, [&](gelight::Index i) {
    const auto row = static_cast<std::size_t>(i);
    Picture first, second;
    std::int32_t sensor = 0;
    bool is_of_one_press = true;
    {
      const auto guard = hdf5::lock();
      first = image_of(a, row);
      second = image_of(b, row);
      sensor = a.row<std::int32_t>("sensor", row)[0];
      is_of_one_press = press_of(a, objects, row) == press_of(b, objects_of_b, row);
    }
    all[row] = likeness(first, second);
    all[row].sensor = sensor;
    all[row].is_of_one_press = is_of_one_press;
  });
  print(all, lines(a.attribute("sensors")));
  if (!picture.empty()) draw(picture, a, b, all);
}

}  // namespace

int main(int argc, char** argv) try {
  std::string one, other, picture;
  CommandLine line("Tells how much the images of two datasets are alike.");
  line.add_required("one", one, "an HDF5 file of dataset");
  line.add_required("other", other, "another, of as many images");
  line.add("--picture", picture, "a PNG file for pairs and their differences");
  line.read(argc, argv);
  hdf5::be_quiet();
  outlive_file_limits();
  compare(one, other, picture);
  return 0;
} catch (...) {
  return told();
}
