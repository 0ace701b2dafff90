// Two more light models.

#include "choices.hpp"
#include "gelight/light/models.hpp"
#include "gelight/mesh/nearest.hpp"

namespace page {

Light make_plane_light(const Mesh& membrane) {
  const auto model = std::make_shared<gelight::PlaneLight<float>>(membrane);
  return {[model](const gelight::Led<float>& led, std::span<const Point> points) {
    return model->field(led, points);
  }};
}

Light make_transport_light(const Mesh& membrane) {
  const auto model = std::make_shared<gelight::TransportLight<float>>(membrane);
  const auto surface = std::make_shared<Surface>(membrane);
  return {[model, surface](const gelight::Led<float>& led, std::span<const Point> points) {
    // Light that leaves in all directions leaves a vertex.
    const auto at = gelight::nearest_vertex(*surface, surface->position(led.points.at(0)));
    return model->field(gelight::Led<float>{{gelight::vertex_point<float>(at)}}, points);
  }};
}

}  // namespace page
