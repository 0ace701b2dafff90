// expect: convertible_to|ImageOf
#include "gelight/image/normals.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

int main() {
  const gelight::Image<const char*> words(4, 3, "deep");
  const gelight::TactileRenderer<float> renderer({1, 1, 1, 1, 4, 3}, words, {});
}
