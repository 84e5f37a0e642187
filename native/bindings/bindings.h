#pragma once

#include <pybind11/pybind11.h>

#include "isimp/mesh/io.h"
#include "made.h"

/// One function a module of the engine; each adds that module's names to `_core`.
///
/// Everything registered is local to this copy of `_core`, so that two copies (one installed, one inside the Blender
/// add-on) can live in one process.
namespace isimp::bindings {

namespace py = pybind11;

void bind_errors(py::module_& m);
void bind_core(py::module_& m);
void bind_mesh(py::module_& m);
void bind_parallel(py::module_& m);
void bind_partition(py::module_& m);
void bind_convex(py::module_& m);
void bind_curved(py::module_& m);
void bind_interact(py::module_& m);
void bind_meshing(py::module_& m);
void bind_io(py::module_& m);
void bind_simplify(py::module_& m);
void bind_texture(py::module_& m);
void bind_tiles(py::module_& m);

/// Vertices (V, 3), the vertex of each corner (L,), and the first corner of each polygon (Q,).
/// \throws InvalidInput  another shape or kind of number, or PolygonSoup::check refuses it
PolygonSoup read_soup(const py::object& vertices, const py::object& loops, const py::object& loop_start);

}  // namespace isimp::bindings
