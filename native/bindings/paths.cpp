#include "paths.h"

#include <pybind11/stl/filesystem.h>

#include <string>

#include "isimp/core/errors.h"

namespace isimp::bindings {

std::filesystem::path to_path(const py::object& value) {
  const auto name = py::reinterpret_steal<py::object>(PyOS_FSPath(value.ptr()));
  if (!name) {
    if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();  // Ctrl-C, as one
    PyErr_Clear();
    throw py::type_error("path must be a str, bytes or os.PathLike, got a " +
                         std::string(py::str(py::type::of(value).attr("__name__"))));
  }
  py::detail::make_caster<std::filesystem::path> caster;
  if (!caster.load(name, false)) throw FileError(std::string(py::repr(name)) + ": no file can have this name");
  return py::detail::cast_op<std::filesystem::path&&>(std::move(caster));
}

}  // namespace isimp::bindings
