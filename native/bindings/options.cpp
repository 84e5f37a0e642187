#include "options.h"

#include <algorithm>
#include <optional>

#include "errors_of_python.h"
#include "isimp/core/errors.h"

namespace isimp::bindings {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& wanted, py::handle value) {
  throw InvalidInput(name + " must be " + wanted + ", got " + std::string(py::repr(value)));
}

/// `value` as a Python integer: any integer type (numpy's too), but no bool.
py::int_ exact_integer(py::handle value, const std::string& name) {
  if (PyBool_Check(value.ptr()) != 0 || PyIndex_Check(value.ptr()) == 0) refuse(name, "an integer", value);
  auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) {
    drop_error();
    refuse(name, "an integer", value);
  }
  return py::int_(number);
}

/// A string of Python's; nothing if it has halves of characters (lone surrogates), which no text has.
std::optional<std::string> utf8_of(py::handle value) {
  Py_ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
  if (text != nullptr) return std::string(text, static_cast<std::size_t>(size));
  drop_error();
  return {};
}

std::string range(const std::string& low, const std::string& high) {
  return "an integer in [" + low + ", " + high + "]";
}

}  // namespace

std::int64_t to_integer(py::handle value, const std::string& name, std::int64_t low, std::int64_t high) {
  const py::int_ number = exact_integer(value, name);
  int overflow = 0;
  const long long result = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  if (overflow != 0 || result < low || result > high)
    refuse(name, range(std::to_string(low), std::to_string(high)), value);
  return result;
}

std::uint64_t to_unsigned(py::handle value, const std::string& name) {
  const py::int_ number = exact_integer(value, name);
  const unsigned long long result = PyLong_AsUnsignedLongLong(number.ptr());
  if (PyErr_Occurred() != nullptr) {
    drop_error();
    refuse(name, range("0", std::to_string(std::numeric_limits<std::uint64_t>::max())), value);
  }
  return result;
}

double to_number(py::handle value, const std::string& name) {
  const bool fits = PyFloat_Check(value.ptr()) != 0 || PyIndex_Check(value.ptr()) != 0 ||
                    (py::hasattr(value, "__float__") && !py::hasattr(value, "__len__"));
  if (!fits || PyBool_Check(value.ptr()) != 0) refuse(name, "a number", value);
  const double result = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) {
    drop_error();
    refuse(name, "a number", value);
  }
  return result;
}

bool to_bool(py::handle value, const std::string& name) {
  if (PyBool_Check(value.ptr()) == 0 && !py::isinstance(value, py::module_::import("numpy").attr("bool_")))
    refuse(name, "True or False", value);
  return PyObject_IsTrue(value.ptr()) == 1;
}

std::string to_text(py::handle value, const std::string& name) {
  if (PyUnicode_Check(value.ptr()) == 0) refuse(name, "a string", value);
  const std::optional<std::string> text = utf8_of(value);
  if (!text) refuse(name, "a string without lone surrogates", value);
  return *text;
}

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

std::size_t to_choice(py::handle value, const std::string& name, const std::vector<std::string>& names) {
  if (PyUnicode_Check(value.ptr()) != 0) {
    const auto at = std::find(names.begin(), names.end(), utf8_of(value));
    if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
  }
  std::string known;
  for (const std::string& text : names) known += (known.empty() ? "'" : ", '") + text + "'";
  refuse(name, "one of " + known, value);
}

}  // namespace isimp::bindings
