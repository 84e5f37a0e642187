#include "paths.h"

#include <pybind11/stl/filesystem.h>

#include <string>

#include "errors_of_python.h"
#include "isimp/core/errors.h"

namespace isimp::bindings {

std::filesystem::path to_path(const py::object& value) {
  const auto name = py::reinterpret_steal<py::object>(PyOS_FSPath(value.ptr()));
  if (!name) {
    drop_error();
    throw py::type_error("path must be a str, bytes or os.PathLike, got a " +
                         std::string(py::str(py::type::of(value).attr("__name__"))));
  }
  py::detail::make_caster<std::filesystem::path> caster;
  if (!caster.load(name, false)) throw FileError(std::string(py::repr(name)) + ": no file can have this name");
  return py::detail::cast_op<std::filesystem::path&&>(std::move(caster));
}

}  // namespace isimp::bindings
