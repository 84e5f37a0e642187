#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>

namespace isimp::bindings {

namespace py = pybind11;

/// A str, bytes or os.PathLike as a path.
/// \throws FileError       no file can have that name: it holds a zero, or half a character (a lone surrogate)
/// \throws py::type_error  another type
std::filesystem::path to_path(const py::object& value);

}  // namespace isimp::bindings
