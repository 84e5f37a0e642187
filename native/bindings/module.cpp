// The module isimp_engine._core.
#include <pybind11/pybind11.h>

#include "bindings.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The engine of isimp: arrays in, arrays out.";
  m.attr("__version__") = ISIMP_VERSION;
  isimp::bindings::bind_errors(m);
  isimp::bindings::bind_core(m);
  isimp::bindings::bind_mesh(m);
  isimp::bindings::bind_parallel(m);
  isimp::bindings::bind_partition(m);
  isimp::bindings::bind_curved(m);
  isimp::bindings::bind_interact(m);
  isimp::bindings::bind_meshing(m);
  isimp::bindings::bind_convex(m);
  isimp::bindings::bind_io(m);
  isimp::bindings::bind_simplify(m);
  isimp::bindings::bind_texture(m);
  isimp::bindings::bind_tiles(m);
}
