// Renderers of tactile images: the page's only loops that run for every image.

#include <limits>

#include "choices.hpp"
#include "gelight/membrane/bulge.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

namespace page {

namespace {

using Frame = gelight::TactileFrame<float>;
using gelight::GaussianMembrane;

template <class Membrane>
class RendererOf : public Renderer {
 public:
  template <class... Parts>
  explicit RendererOf(Parts&&... parts) : renderer_(std::forward<Parts>(parts)...) {}
  void render(Frame& frame, const gelight::Image<float>& depth) const override {
    renderer_.render_next_into(frame, depth);
  }
  [[nodiscard]] Frame rest() const override { return renderer_.rest_frame(); }

 private:
  gelight::TactileRenderer<float, Membrane> renderer_;
};

float mean_depth(const gelight::Image<float>& depth) {
  float sum = 0, count = 0;
  for (const float z : depth.pixels()) {
    if (!(z < std::numeric_limits<float>::infinity())) continue;
    sum += z;
    ++count;
  }
  return sum / count;
}

}  // namespace

std::unique_ptr<Renderer> make_renderer(const Sensor& sensor, const gelight::Raster<float>& rest,
                                        const Lights& lights, LightKind light, SmoothingKind kind) {
  // Straight light runs through space, the others' in the membrane.
  gelight::PhongLights<float> shine{.lights = lights,
                                    .background = gelight::coating_light(sensor, rest),
                                    .ambient = sensor.options.ambient,
                                    .rectify = light != LightKind::linear};
  const auto with = [&]<class Membrane>(Membrane membrane) -> std::unique_ptr<Renderer> {
    return std::make_unique<RendererOf<Membrane>>(sensor.camera, rest.depth, std::move(membrane),
                                                  std::move(shine));
  };
  // A published sigma of 5 pixels is for images of 640 x 480.
  const double scale = sensor.camera.width / 640.0;
  const auto gaussian = [&](double sigma) {
    return GaussianMembrane<float>(sigma, static_cast<Index>(std::ceil(4 * sigma)));
  };
  switch (kind) {
    case SmoothingKind::none:
      return with(GaussianMembrane<float>(0, 0));
    case SmoothingKind::gaussian:
      return with(gaussian(5 * scale));
    case SmoothingKind::wide:
      return with(gaussian(12 * scale));
    case SmoothingKind::layer:
      return with(
          gelight::BulgingMembrane<float>(sensor.camera, mean_depth(rest.depth), sensor.gel));
  }
  gelight::detail::require(false, "there is no smoothing ", static_cast<int>(kind));
  return {};
}

}  // namespace page
