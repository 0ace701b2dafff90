#include "arrays.hpp"

#include <utility>

namespace {

// Numbers wider than an index, none of which may be lost.
template <class Wide>
Packed<Index> narrowed(const py::array& array, const char* what) {
  const Packed<Wide> wide(array);
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    gelight::detail::require(std::in_range<Index>(wide.data()[i]), what, " has ", wide.data()[i],
                             ", which is beyond what an index can be");
  }
  return Packed<Index>(array);
}

// Python's or NumPy's, or an array of one.
bool is_truth(py::handle object) {
  if (PyLong_Check(object.ptr()) != 0) return PyBool_Check(object.ptr()) != 0;
  if (!py::hasattr(object, "dtype")) return false;
  const py::array array = py::array::ensure(object);
  PyErr_Clear();
  return array && array.dtype().kind() == 'b';
}

}  // namespace

void require_unmasked(py::handle object, const char* what) {
  const bool may_be = py::isinstance<py::array>(object) &&
                      Py_TYPE(object.ptr()) != py::detail::npy_api::get().PyArray_Type_;
  if (!may_be || !py::hasattr(object, "mask")) return;
  const auto hidden = py::module_::import("numpy").attr("count_nonzero")(object.attr("mask"));
  gelight::detail::require(hidden.cast<py::ssize_t>() == 0, what, " has ",
                           hidden.cast<py::ssize_t>(), " masked numbers");
}

py::array array_itself(py::handle object, const char* what) {
  if (!py::isinstance<py::array>(object)) {
    throw py::type_error(std::string(what) + " is " +
                         py::repr(py::type::handle_of(object)).cast<std::string>() +
                         ", not an array to be written to");
  }
  require_unmasked(object, what);  // what is written beneath a mask, nobody would see
  return py::reinterpret_borrow<py::array>(object);
}

Packed<Index> indices_in(py::handle object, const char* what) {
  // Of no numbers NumPy does not know of which type they are.
  const py::array any = array_in(object, "fiu", what);
  const py::array array = any.size() == 0 ? any : array_in(any, "iu", what);
  if (has_type<Index>(array) || array.size() == 0) return Packed<Index>(array);
  if (array.dtype().kind() == 'u') return narrowed<std::uint64_t>(array, what);
  return narrowed<std::int64_t>(array, what);
}

Packed<Index> index_row_in(py::handle object, const char* what) {
  Packed<Index> row = indices_in(object, what);
  gelight::detail::require(row.ndim() == 1, what, " has shape ", shape_text(row),
                           ", not that of a row of numbers");
  return row;
}

Packed<Index> faces_in(py::handle object) {
  Packed<Index> faces = indices_in(object, "faces");
  gelight::detail::require(faces.size() == 0 || (faces.ndim() == 2 && faces.shape(1) == 3),
                           "faces has shape ", shape_text(faces), ", not (any, 3)");
  return faces;
}

Index index_in(py::handle object, const char* what) {
  if (is_truth(object)) {  // a mask's, which would be vertices 0 and 1
    throw py::type_error(std::string(what) + " is " + py::repr(object).cast<std::string>() +
                         ", not a whole number");
  }
  const auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
  if (!whole) {
    PyErr_Clear();
    throw py::type_error(std::string(what) + " is " + py::repr(object).cast<std::string>() +
                         ", not a whole number");
  }
  int overflow = 0;
  const long long value = PyLong_AsLongLongAndOverflow(whole.ptr(), &overflow);
  gelight::detail::require(overflow == 0 && std::in_range<Index>(value), what, " ",
                           py::str(whole).cast<std::string>(), " is beyond what an index can be");
  return static_cast<Index>(value);
}

Vec3<double> vector_in(py::handle object, const char* what) {
  const auto numbers = numbers_in<double>(object, what);
  gelight::detail::require(numbers.size() == 3, what, " has ", numbers.size(), " numbers, not 3");
  return {numbers.data()[0], numbers.data()[1], numbers.data()[2]};
}

Vec2<double> pixel_in(py::handle object, const char* what) {
  const auto numbers = numbers_in<double>(object, what);
  gelight::detail::require(numbers.size() == 2, what, " has ", numbers.size(), " numbers, not 2");
  return {numbers.data()[0], numbers.data()[1]};
}

std::string path_in(const py::object& path) {
  // As bytes: not every name is text.
  auto name = py::module_::import("os").attr("fsencode")(path).cast<std::string>();
  gelight::detail::require(name.find('\0') == std::string::npos, "the file's name ",
                           py::repr(path).cast<std::string>(), " has a null character");
  return name;
}

DepthImage::DepthImage(py::handle object, const char* what) {
  py::array array = array_in(object, "f", what);
  gelight::detail::require(array.ndim() == 2, what, " has shape ", shape_text(array),
                           ", not (height, width)");
  kept_ = has_type<float>(array) && is_aligned(array) ? array : py::array(Packed<float>(array));
  view_ = ImageView<const float>::from_bytes(
      static_cast<const float*>(kept_.data()), static_cast<Index>(kept_.shape(1)),
      static_cast<Index>(kept_.shape(0)), kept_.strides(0), kept_.strides(1));
}
