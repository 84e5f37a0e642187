// The Python function that lists the back ends.
#include <pybind11/stl.h>

#include "bindings.h"
#include "ending.h"
#include "isimp/thesis/thesis.h"

namespace isimp::bindings {

void bind_parallel(py::module_& m) {
  m.def("backends", &backends, py::call_guard<Unlocked>(),
        "The names that PartitionOptions.backend takes here: 'cpu' always, 'cuda' where a device is present.");
}

}  // namespace isimp::bindings
