#pragma once

// NumPy's arrays as what the library takes, and what it returns as arrays: without a copy wherever
// the layout allows.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gelight/gelight.hpp"

namespace py = pybind11;

using gelight::Image;
using gelight::ImageView;
using gelight::Index;
using gelight::Rgb8;
using gelight::Vec2;
using gelight::Vec3;
using Surface = gelight::Surface<double>;
using Point = gelight::SurfacePoint<double>;

/// Works while other threads of Python run.
template <class Work>
auto without_gil(const Work& work) {
  const py::gil_scoped_release release;
  return work();
}

// --- out ---------------------------------------------------------------------------------------

/// An array over a vector's numbers, which it owns from now on.
template <class Scalar, class Element>
py::array_t<Scalar> array_of(std::vector<Element> values, std::vector<py::ssize_t> shape) {
  using Vector = std::vector<Element>;
  auto owned = std::make_unique<Vector>(std::move(values));
  auto* const data = reinterpret_cast<Scalar*>(owned->data());
  const py::capsule owner(owned.get(), [](void* p) { delete static_cast<Vector*>(p); });
  (void)owned.release();  // the capsule's now
  return py::array_t<Scalar>(std::move(shape), data, owner);
}

template <class T>
py::array_t<T> array_of(std::vector<T> values) {
  const auto count = static_cast<py::ssize_t>(values.size());
  return array_of<T, T>(std::move(values), {count});
}
template <class T>
py::array_t<T> array_of(std::vector<Vec3<T>> rows) {
  const auto count = static_cast<py::ssize_t>(rows.size());
  return array_of<T, Vec3<T>>(std::move(rows), {count, 3});
}
template <class T>
py::array_t<T> array_of(std::vector<Vec2<T>> rows) {
  const auto count = static_cast<py::ssize_t>(rows.size());
  return array_of<T, Vec2<T>>(std::move(rows), {count, 2});
}
template <class T, std::size_t n>
py::array_t<T> array_of(std::vector<std::array<T, n>> rows) {
  const auto count = static_cast<py::ssize_t>(rows.size());
  return array_of<T, std::array<T, n>>(std::move(rows), {count, static_cast<py::ssize_t>(n)});
}
template <class T, int n>
py::array_t<T> array_of(const Eigen::Matrix<T, n, 1>& vector) {
  return py::array_t<T>(n, vector.data());
}

/// How many numbers a pixel has, and of which type.
template <class P>
struct PixelTraits {
  using Scalar = P;
  static constexpr py::ssize_t count = 1;
};
template <class T, std::size_t n>
struct PixelTraits<std::array<T, n>> {
  using Scalar = T;
  static constexpr py::ssize_t count = n;
};
template <class T, int n>
struct PixelTraits<Eigen::Matrix<T, n, 1>> {
  using Scalar = T;
  static constexpr py::ssize_t count = n;
};

template <class P>
std::vector<py::ssize_t> shape_of(Index width, Index height) {
  if (PixelTraits<P>::count == 1) return {height, width};
  return {height, width, PixelTraits<P>::count};
}

/// An array over an image's pixels, which it owns from now on.
template <class P>
py::array_t<typename PixelTraits<P>::Scalar> array_of(Image<P> image) {
  auto shape = shape_of<P>(image.width(), image.height());
  return array_of<typename PixelTraits<P>::Scalar, P>(std::move(image).pixels(), std::move(shape));
}

/// An array over an image's pixels, which belong to `owner`.
template <class P>
py::array_t<typename PixelTraits<P>::Scalar> view_of(const Image<P>& image, py::handle owner) {
  using Scalar = typename PixelTraits<P>::Scalar;
  return py::array_t<Scalar>(shape_of<P>(image.width(), image.height()),
                             reinterpret_cast<const Scalar*>(image.data()), owner);
}

/// The same, which cannot be written to.
template <class Scalar>
py::array_t<Scalar> read_only(py::array_t<Scalar> array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

// --- in ----------------------------------------------------------------------------------------

/// Throws ValueError for one of numpy.ma's arrays that hides some of its numbers: what lies under a
/// mask would be taken for a value.
void require_unmasked(py::handle object, const char* what);

/// Whatever NumPy makes an array of. Throws TypeError unless its numbers are of one of the kinds
/// named ("f", "i", "u"), ValueError where some are masked.
inline py::array array_in(py::handle object, const char* kinds, const char* what) {
  require_unmasked(object, what);
  py::array array = py::array::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(std::string(what) + " cannot be made an array");
  }
  if (std::string(kinds).find(array.dtype().kind()) == std::string::npos) {
    throw py::type_error(std::string(what) + " has numbers of type " +
                         py::str(array.dtype()).cast<std::string>());
  }
  return array;
}

/// Whether its numbers are of this type, in this machine's order of bytes.
template <class T>
bool has_type(const py::array& array) {
  return py::isinstance<py::array_t<T>>(array);
}
inline bool is_aligned(const py::array& array) {
  return (array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
}

/// An array that is written to. Throws TypeError for anything else, ValueError where some of its
/// numbers are masked.
py::array array_itself(py::handle object, const char* what);

inline std::string shape_text(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

/// Packed and aligned numbers of one type: the array itself where it has them, else a copy.
template <class T>
using Packed = py::array_t<T, py::array::c_style | py::array::forcecast |
                                  py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

/// Numbers in a row. Throws ValueError for another shape.
template <class T>
Packed<T> numbers_in(py::handle object, const char* what) {
  const py::array array = array_in(object, "fiu", what);
  gelight::detail::require(array.ndim() == 1, what, " has shape ", shape_text(array),
                           ", not that of a row of numbers");
  return Packed<T>(array);
}
template <class T>
std::span<const T> span_of(const Packed<T>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// Rows of n numbers.
template <class T, std::size_t n>
Packed<T> rows_in(py::handle object, const char* what) {
  const py::array array = array_in(object, "fiu", what);
  gelight::detail::require(array.ndim() == 2 && array.shape(1) == static_cast<py::ssize_t>(n), what,
                           " has shape ", shape_text(array), ", not (any, ", n, ")");
  return Packed<T>(array);
}
template <std::size_t n, class T>
std::span<const std::array<T, n>> rows_of(const Packed<T>& array) {
  return {reinterpret_cast<const std::array<T, n>*>(array.data()),
          static_cast<std::size_t>(array.size()) / n};
}

/// Whole numbers, of any type of them, as indices. Throws ValueError for what none can be.
Packed<Index> indices_in(py::handle object, const char* what);
/// The same in a row. Throws ValueError for another shape.
Packed<Index> index_row_in(py::handle object, const char* what);
/// The vertices of faces, (m, 3).
Packed<Index> faces_in(py::handle object);

/// One whole number.
Index index_in(py::handle object, const char* what);
/// Three numbers.
Vec3<double> vector_in(py::handle object, const char* what);
/// Column and row of a pixel.
Vec2<double> pixel_in(py::handle object, const char* what);
/// A file's name: text, or what os.PathLike says.
std::string path_in(const py::object& path);

/// A depth image of float32 as it lies in memory, at any strides; a copy where its numbers are
/// others, swapped or not aligned. Throws TypeError for whole numbers, ValueError for another
/// shape.
class DepthImage {
 public:
  DepthImage(py::handle object, const char* what = "the depth image");
  [[nodiscard]] const ImageView<const float>& view() const { return view_; }

 private:
  py::array kept_;
  ImageView<const float> view_;
};

/// An image of pixels with several numbers each, (height, width, n); a copy where those of a pixel
/// do not lie side by side or are of another type.
template <class P>
class PixelImage {
  using Scalar = typename PixelTraits<P>::Scalar;

 public:
  PixelImage(py::handle object, const char* what) {
    py::array array = array_in(object, std::is_integral_v<Scalar> ? "u" : "fiu", what);
    gelight::detail::require(array.ndim() == 3 && array.shape(2) == PixelTraits<P>::count, what,
                             " has shape ", shape_text(array), ", not (height, width, ",
                             PixelTraits<P>::count, ")");
    if (std::is_integral_v<Scalar> && !has_type<Scalar>(array)) {
      throw py::type_error(std::string(what) + " has numbers of type " +
                           py::str(array.dtype()).cast<std::string>() + ", not uint8");
    }
    if (!has_type<Scalar>(array) || !is_aligned(array) || array.strides(2) != sizeof(Scalar)) {
      array = Packed<Scalar>(array);
    }
    kept_ = array;
    view_ = ImageView<const P>::from_bytes(
        static_cast<const P*>(array.data()), static_cast<Index>(array.shape(1)),
        static_cast<Index>(array.shape(0)), array.strides(0), array.strides(1));
  }
  [[nodiscard]] const ImageView<const P>& view() const { return view_; }
  [[nodiscard]] Image<P> copy() const {
    Image<P> image(view_.width(), view_.height());
    for (Index y = 0; y < image.height(); ++y) {
      for (Index x = 0; x < image.width(); ++x) image(x, y) = view_(x, y);
    }
    return image;
  }

 private:
  py::array kept_;
  ImageView<const P> view_;
};

/// An image of the caller's that is written to: where it lies, at any strides, but for pixels whose
/// numbers do not lie side by side (channels in reverse, planes) or rows that have to be packed,
/// which are written beside it and copied. Throws TypeError for what is no array, which nobody
/// would see written, and for other numbers than the pixel's; ValueError for another shape and for
/// an array that is read-only.
template <class P>
class OutputImage {
  using Scalar = typename PixelTraits<P>::Scalar;

 public:
  OutputImage(py::handle object, const char* what, bool packed_rows = false)
      : array_(array_itself(object, what)) {
    if (!has_type<Scalar>(array_)) {
      throw py::type_error(std::string(what) + " has numbers of type " +
                           py::str(array_.dtype()).cast<std::string>() + ", not " +
                           py::str(py::dtype::of<Scalar>()).cast<std::string>());
    }
    constexpr bool has_channels = PixelTraits<P>::count > 1;
    gelight::detail::require(array_.ndim() == (has_channels ? 3 : 2) &&
                                 (!has_channels || array_.shape(2) == PixelTraits<P>::count),
                             what, " has shape ", shape_text(array_),
                             has_channels ? ", not (height, width, 3)" : ", not (height, width)");
    gelight::detail::require(array_.writeable(), what, " is read-only");
    const bool fits = is_aligned(array_) &&
                      (!has_channels || array_.strides(2) == sizeof(Scalar)) &&
                      (!packed_rows || array_.strides(1) == sizeof(P) || array_.shape(1) <= 1);
    target_ = fits ? array_ : py::array(array_.attr("copy")("C"));
    view_ = ImageView<P>::from_bytes(
        static_cast<P*>(target_.mutable_data()), static_cast<Index>(target_.shape(1)),
        static_cast<Index>(target_.shape(0)), target_.strides(0), target_.strides(1));
  }

  [[nodiscard]] const ImageView<P>& view() const { return view_; }
  /// When all is written.
  void finish() {
    if (!target_.is(array_)) array_[py::ellipsis()] = target_;
  }

 private:
  py::array array_, target_;
  ImageView<P> view_;
};
