// The Python exceptions of the engine.
#include "isimp/core/errors.h"

#include <cstring>
#include <exception>

#include "bindings.h"

namespace isimp::bindings {
namespace {

struct Types {
  py::handle invalid_input, file_error;
};

Types& types() {
  static Types all;
  return all;
}

/// Names of files may be any bytes; names that are no UTF-8 have the form of Python's own names.
void raise(py::handle type, const char* what) {
  const auto text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(what, static_cast<Py_ssize_t>(std::strlen(what)), "surrogateescape"));
  if (text) PyErr_SetObject(type.ptr(), text.ptr());
}

}  // namespace

void bind_errors(py::module_& m) {
  auto& invalid_input = py::register_local_exception<InvalidInput>(m, "InvalidInput", PyExc_ValueError);
  invalid_input.doc() =
      "The arrays, options or indices can't be used; the message says what and where. Nothing changed.";
  auto& file_error = py::register_local_exception<FileError>(m, "FileError", invalid_input);
  file_error.doc() = "A file can't be read or written: missing, of an unknown kind, or damaged.";
  py::register_local_exception<Cancelled>(m, "Cancelled").doc() = "The job was cancelled. Nothing was changed.";
  types() = {invalid_input, file_error};
  py::register_local_exception_translator([](std::exception_ptr error) {
    try {
      if (error) std::rethrow_exception(error);
    } catch (const FileError& e) {
      raise(types().file_error, e.what());
    } catch (const InvalidInput& e) {
      raise(types().invalid_input, e.what());
    }
  });
}

}  // namespace isimp::bindings
