// Camera, rasteriser and what is done to images.

#include "images.hpp"

#include <cmath>

#include "gelight/image/normals.hpp"
#include "gelight/image/plane_fit.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/noise.hpp"
#include "one_at_a_time.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::BorderNormals;
using gelight::Pose;
using gelight::RasterWorkspace;

Background background_in(py::handle object) {
  if (object.is_none()) return {};
  const py::array array = array_in(object, "fiu", "the background");
  if (array.ndim() == 1) {
    const auto rgb = numbers_in<float>(object, "the background");
    gelight::detail::require(rgb.size() == 3, "the background has ", rgb.size(), " numbers, not 3");
    return std::array<float, 3>{rgb.data()[0], rgb.data()[1], rgb.data()[2]};
  }
  if (array.ndim() == 2) return DepthImage(object, "the background").view();
  if (has_type<std::uint8_t>(array)) {
    return PixelImage<Rgb8>(object, "the background").view();
  }
  return PixelImage<std::array<float, 3>>(object, "the background").view();
}

namespace {

void bind_camera(py::module_& m) {
  py::class_<Camera>(
      m, "Camera",
      "A pinhole camera: x to the right, y down, z forward; depth is z. The centre of pixel (u, v) "
      "is at (u, v).")
      .def(py::init([](float fx, float fy, float cx, float cy, Index width, Index height) {
             const Camera camera{fx, fy, cx, cy, width, height};
             camera.require_valid();
             return camera;
           }),
           "fx"_a, "fy"_a, "cx"_a, "cy"_a, "width"_a, "height"_a,
           "Focal lengths, where the optical axis meets the image, and its size; all in pixels.")
      .def_static("from_vertical_fov", &Camera::from_vertical_fov, "fov"_a, "width"_a, "height"_a,
                  "Square pixels, through the middle of the image; the angle between its top and "
                  "bottom edges is in radians.")
      .def_readwrite("fx", &Camera::fx, "Focal length across, in pixels.")
      .def_readwrite("fy", &Camera::fy, "Focal length down, in pixels.")
      .def_readwrite("cx", &Camera::cx, "Column where the optical axis meets the image.")
      .def_readwrite("cy", &Camera::cy, "Row where the optical axis meets the image.")
      .def_readwrite("width", &Camera::width, "Of the image, in pixels.")
      .def_readwrite("height", &Camera::height, "Of the image, in pixels.")
      .def(
          "project",
          [](const Camera& self, py::handle point) {
            return array_of(self.project(vector_in(point, "point").cast<float>().eval()));
          },
          "point"_a, "The pixel where a point with z > 0 appears, float32 (2,).");
  m.def(
      "unproject",
      [](py::handle depth, const Camera& camera) {
        const DepthImage image(depth);
        return array_of(without_gil([&] { return gelight::unproject(image.view(), camera); }));
      },
      "depth"_a, "camera"_a,
      "The point that each pixel sees, float32 (h, w, 3), in the unit of the depth (h, w); NaN "
      "where none is seen.");
  py::enum_<BorderNormals>(m, "BorderNormals", "What the outermost pixels have for a normal.")
      .value("none", BorderNormals::none)
      .value("extrapolated", BorderNormals::extrapolated);
  m.def(
      "sobel_normals",
      [](py::handle depth, const Camera& camera, BorderNormals border) {
        const DepthImage image(depth);
        return array_of(
            without_gil([&] { return gelight::sobel_normals(image.view(), camera, border); }));
      },
      "depth"_a, "camera"_a, "border"_a = BorderNormals::none,
      "The unit normal of the surface at every pixel of a depth image (h, w), towards the camera, "
      "float32 (h, w, 3); zero where no surface is seen around a pixel.");
  m.def(
      "central_normals",
      [](py::handle depth, const Camera& camera) {
        const DepthImage image(depth);
        return array_of(
            without_gil([&] { return gelight::central_normals(image.view(), camera); }));
      },
      "depth"_a, "camera"_a,
      "The same from central differences of four neighbours: sharper, and more shaken by noise. "
      "Zero on the outermost pixels, too.");
  m.def(
      "plane_fit_normals",
      [](py::handle depth, const Camera& camera, Index radius) {
        const DepthImage image(depth);
        return array_of(
            without_gil([&] { return gelight::plane_fit_normals(image.view(), camera, radius); }));
      },
      "depth"_a, "camera"_a, "radius"_a,
      "The normal of the plane that fits the points of a (2 radius + 1)^2 window best, towards the "
      "camera, float32 (h, w, 3), as in the STS sensor's simulator. Zero where no surface is seen "
      "or the window's lie on a line of the image. Raises ValueError for a radius below 1.");
  m.def(
      "add_noise",
      [](py::handle image, double sigma, std::uint64_t seed, std::uint64_t frame) {
        OutputImage<Rgb8> out(image, "the image");
        without_gil([&] {
          gelight::add_noise(out.view(), sigma, seed, frame);
          return 0;
        });
        out.finish();
      },
      "image"_a, "sigma"_a, "seed"_a, "frame"_a = 0,
      "Adds to each channel of a uint8 image (h, w, 3) a normal deviate of standard deviation "
      "`sigma` grey levels; the same for the same seed and frame.");
}

template <class P>
py::object image_of_raster(const py::object& self, Image<P> Raster::*image) {
  return view_of(self.cast<const Raster&>().*image, self);
}

template <class T>
void draw(const py::array& depth, const Surface& mesh, const Pose& pose, const Camera& camera,
          RasterWorkspace* work) {
  OutputImage<T> out(depth, "the depth image", true);
  const OneAtATime alone(work, "the workspace");
  without_gil([&] {
    gelight::rasterize_into<T>(out.view(), mesh, pose, camera.cast<T>(), work);
    return 0;
  });
  out.finish();
}

// Rotations that went through float, a thousand times one after the other, keep lengths within half
// of this; a body that is so much larger is so by a thirtieth of a pixel of a thousand.
constexpr double rotation_rounding = 1e-4;

Eigen::Matrix3d rotation_in(py::handle object) {
  const auto r = rows_in<double, 3>(object, "rotation");
  gelight::detail::require(r.size() == 9, "rotation has shape ", shape_text(r), ", not (3, 3)");
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = r.data()[i];
  const Eigen::Matrix3d product = rotation.transpose() * rotation;
  for (Index i = 0; i < 3; ++i) {
    for (Index k = 0; k < 3; ++k) {
      const double off = std::abs(product(i, k) - (i == k ? 1 : 0));
      gelight::detail::require(off <= rotation_rounding,
                               "rotation is none: the product of its columns ", i, " and ", k,
                               " is ", product(i, k), ", not ", i == k ? 1 : 0);
    }
  }
  const double volume =
      gelight::cross<double>(rotation.col(0), rotation.col(1)).dot(rotation.col(2));
  gelight::detail::require(volume > 0,
                           "rotation is none but a reflection: its determinant is not positive");
  return rotation;
}

void bind_pose(py::module_& m) {
  py::class_<Pose>(m, "Pose",
                   "Where a rigid body is: a point p of it is seen at rotation p + translation, in "
                   "the camera's frame.")
      .def(py::init([](py::handle rotation, py::handle translation) {
             Pose pose;
             if (!rotation.is_none()) pose.rotation = rotation_in(rotation);
             if (!translation.is_none()) pose.translation = vector_in(translation, "translation");
             gelight::detail::require(pose.translation.allFinite(), "translation (",
                                      pose.translation[0], ", ", pose.translation[1], ", ",
                                      pose.translation[2], ") is not finite");
             return pose;
           }),
           "rotation"_a = py::none(), "translation"_a = py::none(),
           "rotation: (3, 3), translation: (3,), in the unit of the mesh; by default none.\n\n"
           "Raises ValueError for a translation that is not finite and for another matrix than a "
           "rotation: products of its columns may be 1e-4 off, as after many rotations in float; a "
           "body of another size or mirrored is another Surface.")
      .def_property_readonly(
          "rotation",
          [](const Pose& pose) {
            py::array_t<double> out({3, 3});
            for (int i = 0; i < 9; ++i) out.mutable_data()[i] = pose.rotation(i / 3, i % 3);
            return out;
          },
          "float64 (3, 3).")
      .def_property_readonly(
          "translation", [](const Pose& pose) { return array_of(pose.translation); },
          "float64 (3,).");
  m.def(
      "placed",
      [](const Surface& mesh, const Pose& pose) {
        gelight::Mesh<double> copy;
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
          const auto& p = mesh.position(v);
          copy.positions.push_back({p[0], p[1], p[2]});
        }
        for (Index f = 0; f < mesh.face_count(); ++f) copy.faces.push_back(mesh.face(f));
        return Surface(gelight::placed<double>(std::move(copy), pose.rotation, pose.translation));
      },
      "mesh"_a, "pose"_a, "A copy of a mesh turned, then moved, by a Pose.");
}

void bind_raster(py::module_& m) {
  py::class_<RasterWorkspace>(m, "RasterWorkspace",
                              "Memory that `rasterize_into` works in: with one kept from frame to "
                              "frame it is faster. Of one thread at a time.")
      .def(py::init<>());
  py::class_<Raster>(m, "Raster", "What the camera sees of a mesh, per pixel.")
      .def_property_readonly(
          "depth", [](const py::object& self) { return image_of_raster(self, &Raster::depth); },
          "z, float32 (h, w), in the unit of the positions; +inf: nothing.")
      .def_property_readonly(
          "face", [](const py::object& self) { return image_of_raster(self, &Raster::face); },
          "int32 (h, w); -1 where there is nothing.")
      .def_property_readonly(
          "barycentric",
          [](const py::object& self) { return image_of_raster(self, &Raster::barycentric); },
          "Of the pixel's point in its face, float32 (h, w, 3).");
  m.def(
      "rasterize",
      [](const Surface& mesh, const Camera& camera) {
        return without_gil([&] { return gelight::rasterize(mesh, camera); });
      },
      "mesh"_a, "camera"_a,
      "The nearest face that each pixel's ray meets, seen from the origin along +z; both sides of "
      "a face are seen.");
  m.def(
      "rasterize_into",
      [](py::handle object, const Surface& mesh, const Pose& pose, const Camera& camera,
         RasterWorkspace* workspace) {
        const py::array depth = array_itself(object, "the depth image");
        if (has_type<double>(depth)) {
          draw<double>(depth, mesh, pose, camera, workspace);
        } else {
          draw<float>(depth, mesh, pose, camera, workspace);
        }
      },
      "depth"_a, "mesh"_a, "pose"_a, "camera"_a, "workspace"_a = py::none(),
      "Draws a moved mesh over what a depth image (h, w), float32 or float64, shows already, "
      "wherever it is nearer. Begin with +inf everywhere.");
}

}  // namespace

void bind_images(py::module_& m) {
  bind_camera(m);
  bind_pose(m);
  bind_raster(m);
}
