// expect: ImageOf|ImageLike
#include "gelight/sensor/tactile_renderer.hpp"

struct NotAnImage {};

int main() {
  const gelight::Image<float> rest(4, 3, 1);
  const gelight::TactileRenderer<float> renderer({1, 1, 1, 1, 4, 3}, rest, {});
  const auto image = renderer.render(NotAnImage{});
}
