#pragma once

// What is compiled once, for float and double, where GELIGHT_COMPILED is defined: programs that
// define it compile in a fraction of the time, and link gelight.cpp (CMake's target
// gelight::compiled does both). The same code as without, so the same results.

#include "gelight/gelight.hpp"

// Each template with what `extern` or nothing in front declares or defines it.
#define GELIGHT_FOR_SCALAR(how, T)                                                                \
  how template class Surface<T>;                                                                  \
  how template class DijkstraSolver<T>;                                                           \
  how template class FastMarchingSolver<T>;                                                       \
  how template class VirtualSourceSolver<T>;                                                      \
  how template class ExactSolver<T>;                                                              \
  how template class ExactField<T>;                                                               \
  how template class PathSolver<T>;                                                               \
  how template class HeatSolver<T>;                                                               \
  how template class DistancePlanner<T>;                                                          \
  how template class Certifier<T>;                                                                \
  how template class detail::DistanceQueries<DijkstraSolver<T>, T>;                               \
  how template class detail::DistanceQueries<FastMarchingSolver<T>, T>;                           \
  how template class detail::DistanceQueries<VirtualSourceSolver<T>, T>;                          \
  how template class detail::DistanceQueries<ExactSolver<T>, T>;                                  \
  how template class detail::DistanceQueries<HeatSolver<T>, T>;                                   \
  how template class detail::DistanceQueries<DistancePlanner<T>, T>;                              \
  how template class SmoothDistanceSolver<T>;                                                     \
  how template class detail::DistanceQueries<SmoothDistanceSolver<T>, T>;                         \
  how template class VectorHeatSolver<T>;                                                         \
  how template class SpringBed<T>;                                                                \
  how template class SeeThroughRenderer<T>;                                                       \
  how template class TactileRenderer<T>;                                                          \
  how template Mesh<T> grid<T>(Index, Index, T, T);                                               \
  how template Mesh<T> icosphere<T>(int, T);                                                      \
  how template Mesh<T> torus<T>(T, T, Index, Index);                                              \
  how template Mesh<T> placed<T>(Mesh<T>, const Eigen::Matrix<T, 3, 3>&, const Vec3<T>&);         \
  how template Mesh<T> joined<T>(std::span<const Mesh<T>>);                                       \
  how template SensorPreset<T> geltip<T>(Index, Index, T);                                        \
  how template SensorPreset<T> gelsight_mini<T>(Index, Index, T);                                 \
  how template SensorPreset<T> digit<T>(Index, Index, T);                                         \
  how template SensorPreset<T> sts<T>(Index, Index, T);                                           \
  how template TactileRenderer<T> tactile_renderer<T>(const SensorPreset<T>&);                    \
  how template Mesh<T> membrane<T>(T, T, T);                                                      \
  how template Raster<T> rasterize<T, Mesh<T>>(const Mesh<T>&, const Camera<T>&);                 \
  how template Raster<T> rasterize<T, MeshView<T>>(const MeshView<T>&, const Camera<T>&);         \
  how template void rasterize_into<T, Mesh<T>>(ImageView<T>, const Mesh<T>&, const Pose&,         \
                                               const Camera<T>&, RasterWorkspace*);               \
  how template std::vector<SurfacePoint<T>> pixel_points<T>(const Raster<T>&);                    \
  how template Image<Vec3<T>> bake<T>(const LightField<T>&, const Raster<T>&, const CancelHook&); \
  how template LightField<T> geodesic_field<T>(const ExactSolver<T>&, const SurfacePoint<T>&,     \
                                               std::span<const SurfacePoint<T>>,                  \
                                               const CancelHook&);                                \
  how template LightField<T> geodesic_field<T>(const ExactSolver<T>&, std::span<const Source<T>>, \
                                               std::span<const SurfacePoint<T>>,                  \
                                               const CancelHook&);
#define GELIGHT_FOR_MESH(how, T, M)                                      \
  how template auto Surface<T>::snapshot<M>(const M&, const CancelHook&) \
      ->std::shared_ptr<const Data>;
// What computes in double whatever it is asked in.
#define GELIGHT_FOR_DOUBLE(how)                                  \
  how template class TangentFrames<double>;                      \
  how template class SymmetricPattern<double>;                   \
  how template class detail::Dissection<double>;                 \
  how template class detail::SparseFactor<double>;               \
  how template class detail::SparseFactor<std::complex<double>>; \
  how template struct detail::HeatSystem<double>;
#define GELIGHT_FOR_ALL(how)                     \
  GELIGHT_FOR_DOUBLE(how)                        \
  GELIGHT_FOR_SCALAR(how, float)                 \
  GELIGHT_FOR_SCALAR(how, double)                \
  GELIGHT_FOR_MESH(how, float, Mesh<float>)      \
  GELIGHT_FOR_MESH(how, float, MeshView<float>)  \
  GELIGHT_FOR_MESH(how, double, Mesh<float>)     \
  GELIGHT_FOR_MESH(how, double, MeshView<float>) \
  GELIGHT_FOR_MESH(how, double, Mesh<double>)    \
  GELIGHT_FOR_MESH(how, double, MeshView<double>)

#if defined(GELIGHT_COMPILED)
namespace gelight {

GELIGHT_FOR_ALL(extern)

}  // namespace gelight
#endif
