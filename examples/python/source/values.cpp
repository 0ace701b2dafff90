// What is plain data and is pickled and copied by value; all else is refused (guard.cpp).

#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/light/models.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/presets.hpp"
#include "gelight/sensor/see_through.hpp"
#include "gelight/transport/vector_heat.hpp"
#if defined(GELIGHT_HAS_EMBREE)
#include "gelight/light/traced.hpp"
#endif

#include "by_value.hpp"
#include "images.hpp"
#include "points.hpp"
#include "topics.hpp"

template <>
struct Kept<gelight::Finding> {
  using State = std::tuple<Index, std::vector<Index>>;
  static State state(const gelight::Finding& found) { return {found.count, found.first}; }
  static gelight::Finding value(const State& state) {
    return {std::get<0>(state), std::get<1>(state)};
  }
};

template <>
struct Kept<gelight::Circle> {
  using State = std::array<double, 3>;
  static State state(const gelight::Circle& circle) { return {circle.x, circle.y, circle.radius}; }
  static gelight::Circle value(const State& state) { return {state[0], state[1], state[2]}; }
};

namespace {

using Points = Kept<std::vector<Point>>;

// Those that are not members only.
void keep_geometry() {
  using Corners = Kept<gelight::Mesh<double>>;
  py::class_<Surface>(py::type::of<Surface>())
      .def(py::pickle(
          [](const Surface& surface) {
            gelight::Mesh<double> mesh;
            for (Index v = 0; v < surface.vertex_count(); ++v) {
              const auto& p = surface.position(v);
              mesh.positions.push_back({p[0], p[1], p[2]});
            }
            for (Index f = 0; f < surface.face_count(); ++f) mesh.faces.push_back(surface.face(f));
            return Corners::state(mesh);
          },
          [](const Corners::State& state) { return Surface(Corners::value(state)); }));
  py::class_<Point>(py::type::of<Point>())
      .def(py::pickle([](const Point& p) { return Points::one(p); },
                      [](const Points::One& state) { return Points::point(state); }));
  using Path = std::tuple<Surface, Points::State>;
  py::class_<PathOn>(py::type::of<PathOn>())
      .def(py::pickle(
          [](const PathOn& path) {
            return Path{path.surface, Points::state(path.points)};
          },
          [](const Path& state) {
            PathOn path{std::get<0>(state), Points::value(std::get<1>(state))};
            for (const Point& p : path.points) path.surface.require_point(p);
            return path;
          }));
  using Edge = std::tuple<std::array<Index, 2>, PathOn, bool>;
  py::class_<BorderOn>(py::type::of<BorderOn>())
      .def(py::pickle(
          [](const BorderOn& edge) {
            return Edge{edge.sources, edge.points, edge.is_closed};
          },
          [](const Edge& state) {
            return BorderOn{std::get<0>(state), std::get<1>(state), std::get<2>(state)};
          }));
  using Source = gelight::Source<double>;
  keep_by_value(&Source::point, &Source::distance);
}

void keep_meshes() {
  using Report = gelight::MeshReport;
  keep_by_value(&Report::vertices, &Report::faces, &Report::not_finite, &Report::too_far,
                &Report::is_too_small, &Report::out_of_range, &Report::repeated_vertices,
                &Report::repeated_faces, &Report::too_long, &Report::nonmanifold_edges,
                &Report::misoriented_edges, &Report::degenerate_faces, &Report::zero_edges,
                &Report::duplicate_vertices, &Report::unused_vertices,
                &Report::nonmanifold_vertices, &Report::border_edges, &Report::components);
  using Repaired = gelight::Repaired<double>;
  keep_by_value(&Repaired::mesh, &Repaired::welded_vertices, &Repaired::dropped_faces,
                &Repaired::turned_faces, &Repaired::added_vertices, &Repaired::dropped_vertices,
                &Repaired::vertex_of, &Repaired::face_of);
}

void keep_distances() {
  using Heat = gelight::HeatResult<double>;
  keep_by_value(&Heat::distance, &Heat::error, &Heat::residual, &Heat::is_too_coarse,
                &Heat::is_too_far, &Heat::is_reliable);
  using Arrival = gelight::ExactArrival<double>;
  keep_by_value(&Arrival::distance, &Arrival::direction, &Arrival::from);
  using Departure = gelight::ExactDeparture<double>;
  keep_by_value(&Departure::direction, &Departure::halfedge, &Departure::angle);
  using Arc = gelight::CircularArc<double>;
  keep_by_value(&Arc::face, &Arc::begin, &Arc::end, &Arc::centre, &Arc::radius, &Arc::angle,
                &Arc::length);
  using Line = gelight::ExactIsoline<double>;
  keep_by_value(&Line::arcs, &Line::is_closed);
  using Smooth = gelight::SmoothPath<double>;
  keep_by_value(&Smooth::positions, &Smooth::on_mesh, &Smooth::length, &Smooth::direction,
                &Smooth::trust);
  using Transport = gelight::TransportResult<double>;
  keep_by_value(&Transport::vectors, &Transport::error, &Transport::is_reliable);
  using LogMap = gelight::LogMapResult<double>;
  keep_by_value(&LogMap::coordinates, &LogMap::error, &LogMap::is_reliable);
}

void keep_plans() {
  using gelight::MethodCost, gelight::PlanCosts, gelight::RelativeError;
  keep_by_value(&RelativeError::mean, &RelativeError::max);
  using Bounds = gelight::DistanceBounds<double>;
  keep_by_value(&Bounds::lower, &Bounds::upper);
  keep_by_value(&MethodCost::setup_ns, &MethodCost::query_ns, &MethodCost::growth,
                &MethodCost::bytes);
  keep_by_value(&PlanCosts::dijkstra, &PlanCosts::virtual_source, &PlanCosts::fast_marching,
                &PlanCosts::exact, &PlanCosts::certificate, &PlanCosts::paths,
                &PlanCosts::sample_share);
  using Plan = gelight::DistancePlan;
  keep_by_value(&Plan::method, &Plan::expected_to_satisfy, &Plan::expected_error, &Plan::unfamiliar,
                &Plan::seconds, &Plan::bytes, &Plan::refine_to, &Plan::reason);
  using Planned = gelight::PlannedDistances<double>;
  keep_by_value(&Planned::distance, &Planned::method, &Planned::achieved, &Planned::error,
                &Planned::checked, &Planned::satisfies, &Planned::reason);
}

void keep_images() {
  keep_by_value(&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy, &Camera::width,
                &Camera::height);
  using gelight::Pose;
  keep_by_value(&Pose::rotation, &Pose::translation);
  using gelight::LevelDifference;
  keep_by_value(&LevelDifference::pixels, &LevelDifference::worst, &LevelDifference::mean);
  keep_by_value(&Raster::depth, &Raster::face, &Raster::barycentric);
}

void keep_light() {
  using Light = gelight::Light<float>;
  keep_by_value(&Light::direction, &Light::rgb, &Light::diffuse, &Light::specular,
                &Light::shininess);
  using Led = gelight::Led<float>;
  keep_by_value(&Led::points, &Led::emission);
  using Rays = gelight::LightRays<float>;
  keep_by_value(&Rays::direction, &Rays::distance, &Rays::lighting);
#if defined(GELIGHT_HAS_EMBREE)
  using gelight::InnerLayer;
  py::class_<InnerLayer>(py::type::of<InnerLayer>())
      .def(py::pickle(
          [](const InnerLayer& layer) {
            return std::make_tuple(layer.surface, layer.index, layer.absorption);
          },
          [](const std::tuple<Surface, double, double>& state) {
            return InnerLayer{std::get<0>(state), std::get<1>(state), std::get<2>(state)};
          }));
  using Balance = gelight::LightBalance;
  keep_by_value(&Balance::coating, &Balance::gel, &Balance::lost, &Balance::cut,
                &Balance::segments);
  using Traced = gelight::TracedLight;
  keep_by_value(&Traced::irradiance, &Traced::irradiance_error, &Traced::direction,
                &Traced::direction_error, &Traced::directed, &Traced::directed_error,
                &Traced::vector, &Traced::vector_error, &Traced::balance, &Traced::balance_error);
#endif
}

void keep_gels() {
  using gelight::Gel;
  keep_by_value(&Gel::elastic_modulus, &Gel::poisson_ratio, &Gel::thickness, &Gel::friction,
                &Gel::tension);
  using gelight::ContactShadow;
  keep_by_value(&ContactShadow::contact, &ContactShadow::sigma, &ContactShadow::radius,
                &ContactShadow::gap);
  using Spring = gelight::SpringContact<float>;
  keep_by_value(&Spring::equilibrium, &Spring::displacement, &Spring::tilt, &Spring::force,
                &Spring::residual_force, &Spring::residual_moment, &Spring::indentation,
                &Spring::touching, &Spring::unknown);
  using Layer = gelight::LayerContact<float>;
  keep_by_value(&Layer::indentation, &Layer::depth, &Layer::pressure, &Layer::traction,
                &Layer::displacement, &Layer::travel, &Layer::tilt, &Layer::force, &Layer::moment,
                &Layer::bend, &Layer::is_bent_too_far, &Layer::converged, &Layer::residual,
                &Layer::iterations, &Layer::convolutions, &Layer::unknown);
}

void keep_sensors() {
  using Tactile = gelight::TactileOptions;
  keep_by_value(&Tactile::smoothing_sigma, &Tactile::smoothing_radius, &Tactile::rectify,
                &Tactile::keep_strength, &Tactile::clip_to_rest, &Tactile::ambient,
                &Tactile::specular, &Tactile::darkening, &Tactile::darkening_depth,
                &Tactile::border_normals, &Tactile::skip_unchanged);
  using gelight::LightLevels;
  keep_by_value(&LightLevels::inner, &LightLevels::outer);
  using Through = gelight::SeeThroughOptions;
  keep_by_value(&Through::thickness, &Through::normal_radius, &Through::ambient,
                &Through::darkening, &Through::darkening_depth, &Through::reflectance,
                &Through::transmittance, &Through::exposure, &Through::levels);
  using Falloff = gelight::Falloff<float>;
  keep_by_value(&Falloff::full_within, &Falloff::absorption);
  using Preset = gelight::SensorPreset<float>;
  keep_by_value(&Preset::membrane, &Preset::camera, &Preset::leds, &Preset::colours,
                &Preset::coating, &Preset::falloff, &Preset::diffuse, &Preset::specular,
                &Preset::shininess, &Preset::options, &Preset::gel, &Preset::led_width,
                &Preset::led_parts, &Preset::full_within);
  using gelight::BallPress, gelight::PressReport, gelight::RegionResidual;
  keep_by_value(&BallPress::name, &BallPress::photograph, &BallPress::contact,
                &BallPress::ball_radius);
  keep_by_value(&PressReport::name, &PressReport::level, &PressReport::contact, &PressReport::doubt,
                &PressReport::is_proposed, &PressReport::fits, &PressReport::residual);
  keep_by_value(&RegionResidual::region, &RegionResidual::signal, &RegionResidual::residual);
}

}  // namespace

void bind_values() {
  keep_geometry();
  keep_meshes();
  keep_distances();
  keep_plans();
  keep_images();
  keep_light();
  keep_gels();
  keep_sensors();
}
