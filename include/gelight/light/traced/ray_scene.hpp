#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"

// A room of light/traced.hpp: surfaces that Embree finds what rays hit on.

namespace gelight::detail {

struct EmbreeRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

/// Several surfaces, moved to the origin and scaled to a box of unit size, in which rays are cast.
/// Embree counts in single precision; where a ray hits is computed anew in double.
class RayScene {
 public:
  /// Where a ray hits, in the scene's own coordinates.
  struct Hit {
    std::size_t surface = 0;
    Index face = -1;
    double u = 0, v = 0;  // barycentric, of the second and third vertex
    double distance = 0;  // in the surfaces' own unit
    Vec3<double> place{0, 0, 0};
  };

  explicit RayScene(std::span<const Surface<double>> surfaces) {
    constexpr double far = unreachable<double>;
    Vec3<double> low(far, far, far), high = -low;
    for (const auto& surface : surfaces) {
      for (Index h = 0; h < surface.halfedge_count(); ++h) {  // of vertices that have faces
        const Vec3<double>& p = surface.position(surface.origin(h));
        low = least_of(low, p), high = greatest_of(high, p);
      }
    }
    centre_ = low / 2 + high / 2;
    scale_ = (high / 2 - low / 2).maxCoeff() * 2;
    // One thread, so that the hierarchy is the same every time.
    device_.reset(rtcNewDevice("threads=1,set_affinity=0"));
    if (!device_) throw std::runtime_error("Embree has no device");
    scene_.reset(rtcNewScene(device_.get()));
    // Without cracks between neighbouring triangles.
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
    for (const auto& surface : surfaces) add(surface);
    rtcCommitScene(scene_.get());
    check();
  }

  /// Coordinates of the scene for a position, and back, and lengths of the surfaces' unit for the
  /// scene's.
  [[nodiscard]] Vec3<double> to_scene(const Vec3<double>& p) const {
    return (p - centre_) / scale_;
  }
  [[nodiscard]] Vec3<double> from_scene(const Vec3<double>& p) const {
    return scale_ * p + centre_;
  }
  [[nodiscard]] double scale() const { return scale_; }

  /// The unit normal of a face.
  [[nodiscard]] const Vec3<double>& normal(std::size_t surface, Index face) const {
    return parts_[surface].normals[face];
  }

  /// The unit normal at a point of a face, smooth across edges that are no creases.
  [[nodiscard]] Vec3<double> smooth_normal(const Hit& hit) const {
    const auto* n = parts_[hit.surface].corner_normals.data() + 3 * std::ptrdiff_t{hit.face};
    const Vec3<double> mean = (1 - hit.u - hit.v) * n[0] + hit.u * n[1] + hit.v * n[2];
    return mean / std::sqrt(squared_norm(mean));
  }

  /// What a ray hits first; false where it hits nothing.
  [[nodiscard]] bool first_hit(const Vec3<double>& from, const Vec3<double>& way, Hit& hit) const {
    RTCRayHit query;
    query.ray = {static_cast<float>(from[0]),
                 static_cast<float>(from[1]),
                 static_cast<float>(from[2]),
                 0,
                 static_cast<float>(way[0]),
                 static_cast<float>(way[1]),
                 static_cast<float>(way[2]),
                 0,
                 std::numeric_limits<float>::infinity(),
                 ~0u,
                 0,
                 0};
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_.get(), &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit.surface = query.hit.geomID;
    hit.face = static_cast<Index>(query.hit.primID);
    hit.u = std::clamp(double{query.hit.u}, 0.0, 1.0);
    hit.v = std::clamp(double{query.hit.v}, 0.0, 1 - hit.u);
    hit.distance = double{query.ray.tfar} * scale_;
    const auto* p = parts_[hit.surface].corners.data() + 3 * std::ptrdiff_t{hit.face};
    hit.place = (1 - hit.u - hit.v) * p[0] + hit.u * p[1] + hit.v * p[2];
    return true;
  }

  /// Where a ray starts that leaves a hit to the side of `way`: off its face by more than rounding
  /// in single precision, so that it cannot hit the same place again or start beyond it.
  [[nodiscard]] Vec3<double> start(const Hit& hit, const Vec3<double>& way) const {
    constexpr double clearance = 2e-6;
    const Vec3<double>& n = normal(hit.surface, hit.face);
    return hit.place + (dot(way, n) > 0 ? clearance : -clearance) * n;
  }

 private:
  struct Part {
    Array<Vec3<double>> corners;         // of each face its three, in the scene's coordinates
    Array<Vec3<double>> normals;         // of each face
    Array<Vec3<double>> corner_normals;  // of each corner, not of unit length
  };

  void check() const {
    const RTCError error = rtcGetDeviceError(device_.get());
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_NONE) {
      throw std::runtime_error("Embree reports error " + std::to_string(static_cast<int>(error)));
    }
  }

  void add(const Surface<double>& surface) {
    // Faces that meet at less than this angle are parts of one smooth surface.
    constexpr double crease_cosine = 0.8;  // 37 degrees
    Part part;
    Array<Vec3<double>> areas;
    for (Index f = 0; f < surface.face_count(); ++f) {
      const Vec3<double> area = face_normal(surface, f) / (scale_ * scale_);
      areas.push_back(area);
      part.normals.push_back(direction_of(area));
      for (const Index v : surface.face(f)) part.corners.push_back(to_scene(surface.position(v)));
    }
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      const Vec3<double>& own = part.normals[Surface<double>::face_of(h)];
      Vec3<double> sum = areas[Surface<double>::face_of(h)];
      for (const Index other : surface.corners(surface.origin(h))) {
        const Index f = Surface<double>::face_of(other);
        if (f == Surface<double>::face_of(h)) continue;
        if (dot(part.normals[f], own) > crease_cosine) sum += areas[f];
      }
      const Vec3<double> unit = direction_of(sum);
      part.corner_normals.push_back(unit.isZero(0) ? Vec3<double>(0, 0, 1) : unit);
    }
    attach(surface);
    parts_.push_back(std::move(part));
  }

  void attach(const Surface<double>& surface) {
    RTCGeometry triangles = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto vertices = static_cast<std::size_t>(surface.vertex_count());
    const auto faces = static_cast<std::size_t>(surface.face_count());
    auto* const positions = static_cast<float*>(rtcSetNewGeometryBuffer(
        triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
    auto* const indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), faces));
    if (positions != nullptr && indices != nullptr) {
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        const Vec3<double> p = to_scene(surface.position(v));
        for (int k = 0; k < 3; ++k) positions[3 * std::ptrdiff_t{v} + k] = static_cast<float>(p[k]);
      }
      for (Index h = 0; h < surface.halfedge_count(); ++h) {
        indices[h] = static_cast<unsigned>(surface.origin(h));
      }
      rtcCommitGeometry(triangles);
      rtcAttachGeometryByID(scene_.get(), triangles, static_cast<unsigned>(parts_.size()));
    }
    rtcReleaseGeometry(triangles);
    check();
  }

  Vec3<double> centre_;
  double scale_ = 1;
  std::vector<Part> parts_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, EmbreeRelease> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, EmbreeRelease> scene_;
};

}  // namespace gelight::detail
