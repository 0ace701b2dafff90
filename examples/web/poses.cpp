// The images that the page's own code makes when compiled for this machine: those of the browser
// are to be the same. poses FOLDER writes press_K.rgba for each line of the standard input,
// "sensor edge object light smoothing solver u v depth turn", -1 as object for none.

#include <cstdio>
#include <fstream>
#include <iostream>
#include <string>

#include "page.hpp"

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: poses FOLDER\n");
    return 2;
  }
  constexpr int width = 320, height = 240;
  int sensor = 0, object = 0, light = 0, smoothing = 0, solver = 0;
  float edge = 0, u = 0, v = 0, depth = 0, turn = 0;
  for (int k = 0; std::cin >> sensor >> edge >> object >> light >> smoothing >> solver >> u >> v >>
                  depth >> turn;
       ++k) {
    const bool is_made = set_sensor(sensor, width, height, edge) >= 0 &&
                         (object < 0 || set_object(object) >= 0) &&
                         set_renderer(light, smoothing, solver) >= 0 &&
                         (object < 0 || press(u, v, depth, turn) >= 0);
    if (!is_made) {
      std::fprintf(stderr, "%s\n", reason());
      return 1;
    }
    const auto* pixels = reinterpret_cast<const char*>(image());
    std::ofstream(std::string(arguments[1]) + "/press_" + std::to_string(k) + ".rgba",
                  std::ios::binary)
        .write(pixels, 4L * width * height);
  }
  return 0;
}
