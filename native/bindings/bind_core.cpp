#include "bindings.h"
#include "ending.h"
#include "isimp/core/job.h"

namespace isimp::bindings {

namespace py = pybind11;

void bind_core(py::module_& m) {
  stop_calls_at_the_end();
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
