// What holds for every class of the module, whatever it binds.

#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>

#include "topics.hpp"

namespace py = pybind11;

namespace {

// pybind11 asks for memory here where an object is used that no constructor has made, such as that
// of `Surface.__new__(Surface)`, and would take what lies there for the object.
void* refuse(std::size_t) {
  throw py::type_error("an object that was not constructed is used: its __init__ was not called");
}

// What copy and pickle ask. Objects of a Python class of the caller's may have attributes, which a
// copy would lose.
py::tuple reduced(const py::object& self) {
  const py::object type = py::type::of(self);
  const bool has_more = py::hasattr(self, "__dict__") && py::len(self.attr("__dict__")) > 0;
  if (has_more || !py::hasattr(type, "__setstate__")) {
    throw py::type_error(type.attr("__module__").cast<std::string>() + "." +
                         type.attr("__qualname__").cast<std::string>() +
                         (has_more ? " has attributes of its own: it cannot be pickled or copied"
                                   : " cannot be pickled or copied"));
  }
  return py::make_tuple(py::module_::import("copyreg").attr("__newobj__"), py::make_tuple(type),
                        self.attr("__getstate__")());
}

}  // namespace

void guard_classes(py::module_& m) {
  for (const auto& [name, value] : py::dict(m.attr("__dict__"))) {
    if (PyType_Check(value.ptr()) == 0) continue;
    auto* const known = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()));
    if (known == nullptr) continue;
    known->operator_new = &refuse;
    value.attr("__reduce__") =
        py::cpp_function(&reduced, py::name("__reduce__"), py::is_method(value));
  }
}
