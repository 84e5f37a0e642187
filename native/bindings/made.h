#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "isimp/core/job.h"
#include "isimp/mesh/clean.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"
#include "isimp/regular/regularise.h"
#include "isimp/simplify/within.h"
#include "isimp/texture/options.h"
#include "isimp/texture/unwrap.h"
#include "kept_mesh.h"
#include "stretch.h"

namespace isimp::bindings {

namespace py = pybind11;

/// Accepts only objects from Python that were initialised: `Mesh.__new__(Mesh)` gives one with nothing behind it, for
/// which pybind11 would allocate memory and not initialise it.
template <class T>
struct Made : py::detail::type_caster_base<T> {
  using Base = py::detail::type_caster_base<T>;

  bool load(py::handle source, bool convert) { return Base::template load_impl<Made>(source, convert); }

 private:
  friend class py::detail::type_caster_generic;

  void load_value(py::detail::value_and_holder&& held) {
    if (held.value_ptr() == nullptr)
      throw py::type_error("this " + std::string(Base::typeinfo->type->tp_name) +
                           " was never made: its __init__ was not " + "called");
    Base::load_value(std::move(held));
  }
};

}  // namespace isimp::bindings

namespace pybind11::detail {

template <>
struct type_caster<isimp::Job> : isimp::bindings::Made<isimp::Job> {};
template <>
struct type_caster<isimp::CleanOptions> : isimp::bindings::Made<isimp::CleanOptions> {};
template <>
struct type_caster<isimp::PartitionOptions> : isimp::bindings::Made<isimp::PartitionOptions> {};
template <>
struct type_caster<isimp::MeshingOptions> : isimp::bindings::Made<isimp::MeshingOptions> {};
template <>
struct type_caster<isimp::RegulariseOptions> : isimp::bindings::Made<isimp::RegulariseOptions> {};
template <>
struct type_caster<isimp::TextureOptions> : isimp::bindings::Made<isimp::TextureOptions> {};
template <>
struct type_caster<isimp::Atlas> : isimp::bindings::Made<isimp::Atlas> {};
template <>
struct type_caster<isimp::BoundSearch> : isimp::bindings::Made<isimp::BoundSearch> {};
template <>
struct type_caster<isimp::BoundSearch::Step> : isimp::bindings::Made<isimp::BoundSearch::Step> {};
template <>
struct type_caster<isimp::bindings::Stretch> : isimp::bindings::Made<isimp::bindings::Stretch> {};
template <>
struct type_caster<isimp::bindings::KeptMesh> : isimp::bindings::Made<isimp::bindings::KeptMesh> {};
template <>
struct type_caster<isimp::Partition> : isimp::bindings::Made<isimp::Partition> {};
template <>
struct type_caster<isimp::PolygonMesh> : isimp::bindings::Made<isimp::PolygonMesh> {};

}  // namespace pybind11::detail
