#pragma once

#include <pybind11/pybind11.h>

namespace isimp::bindings {

/// Drops the exception that Python has set, where a clearer one takes its place. What is no `Exception`, as the
/// KeyboardInterrupt of a Ctrl-C that came while Python's own code ran, is passed on.
/// \throws py::error_already_set
inline void drop_error() {
  if (PyErr_ExceptionMatches(PyExc_Exception) == 0) throw pybind11::error_already_set();
  PyErr_Clear();
}

}  // namespace isimp::bindings
