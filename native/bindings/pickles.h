#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"
#include "kept_mesh.h"

namespace isimp::bindings {

namespace py = pybind11;

/// The state of an object for Python's pickle and copy: numbers and the bytes of its arrays, in this machine's byte
/// order.
///
/// The restored object is equal in all that can be queried; caches are not kept. All three `..._from` functions throw
/// InvalidInput where the numbers don't fit together, so that a damaged pickle gives no object that can't be used.
py::tuple state_of(const KeptMesh& mesh);
std::shared_ptr<KeptMesh> mesh_from(const py::tuple& state);

py::tuple state_of(const Partition& partition);
Partition partition_from_state(const py::tuple& state);

py::tuple state_of(const PolygonMesh& polygons);
PolygonMesh polygons_from(const py::tuple& state);

}  // namespace isimp::bindings
