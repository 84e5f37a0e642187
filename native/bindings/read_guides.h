#pragma once

#include <pybind11/pybind11.h>

#include <optional>

#include "isimp/partition/surface.h"

namespace isimp::bindings {

namespace py = pybind11;

/// weights (F,) and barriers (K, 2); None for missing ones.
/// \throws InvalidInput  another shape or kind of number
Guides read_guides(const std::optional<py::object>& weights, const std::optional<py::object>& barriers);

}  // namespace isimp::bindings
