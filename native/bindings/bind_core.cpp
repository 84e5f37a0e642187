#include "bindings.h"
#include "isimp/core/errors.h"
#include "isimp/core/job.h"

namespace isimp::bindings {

namespace py = pybind11;

void bind_core(py::module_& m) {
  auto& invalid_input = py::register_local_exception<InvalidInput>(m, "InvalidInput", PyExc_ValueError);
  invalid_input.doc() =
      "The arrays, options or indices can't be used; the message says what and where. Nothing changed.";
  auto& file_error = py::register_local_exception<FileError>(m, "FileError", invalid_input);
  file_error.doc() = "A file can't be read or written: missing, of an unknown kind, or damaged.";
  py::register_local_exception<Cancelled>(m, "Cancelled").doc() = "The job was cancelled. Nothing was changed.";

  py::class_<Job>(m, "Job", py::module_local(), R"(What a long call shares with whoever waits for it.

Every function that takes long accepts `job`; read `progress` and `stage` and call `cancel` from any thread meanwhile.
A cancelled job stays cancelled, and progress never falls: take a new Job for each call.)")
      .def(py::init<>())
      .def_property_readonly("progress", &Job::progress, "How much is done, in [0, 1].")
      .def_property_readonly("stage", &Job::stage, "What is being done; '' before the first stage.")
      .def_property_readonly("cancelled", &Job::cancelled, "Whether someone asked to stop.")
      .def("cancel", &Job::cancel, "Ask the call to stop; within 50 ms it raises Cancelled.")
      .def("__repr__", [](const Job& job) {
        return py::str("<Job: {:.0%} {}{}>").format(job.progress(), job.stage(), job.cancelled() ? ", cancelled" : "");
      });
}

}  // namespace isimp::bindings
