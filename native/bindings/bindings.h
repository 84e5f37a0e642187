#pragma once

#include <pybind11/pybind11.h>

/// One function a module of the engine; each adds that module's names to `_core`.
///
/// Everything registered is local to this copy of `_core`, so that two copies (one installed, one inside the Blender
/// add-on) can live in one process.
namespace isimp::bindings {

void bind_core(pybind11::module_& m);
void bind_mesh(pybind11::module_& m);
void bind_partition(pybind11::module_& m);
void bind_interact(pybind11::module_& m);
void bind_meshing(pybind11::module_& m);

}  // namespace isimp::bindings
