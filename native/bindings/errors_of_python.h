// Python's own errors inside the engine's calls.
#pragma once

#include <pybind11/pybind11.h>

namespace isimp::bindings {

/// Drops the exception that Python has set, where a clearer one replaces it. An exception that is no `Exception`, such
/// as the KeyboardInterrupt of a Ctrl-C during Python's own code, is passed on.
/// \throws py::error_already_set
inline void drop_error() {
  if (PyErr_ExceptionMatches(PyExc_Exception) == 0) throw pybind11::error_already_set();
  PyErr_Clear();
}

}  // namespace isimp::bindings
