// The Python class Job, and the number of threads.
#include "bindings.h"
#include "ending.h"
#include "isimp/core/job.h"

namespace isimp::bindings {

namespace py = pybind11;

void bind_core(py::module_& m) {
  stop_calls_at_the_end();
  py::class_<Job>(m, "Job", py::module_local(), R"(Progress and cancellation of a long call.

Every long function accepts `job`. Any thread may read `progress` and `stage`, and call `cancel`, during the call.
A cancelled job stays cancelled, and progress never falls: use a new Job for each call.)")
      .def(py::init<>())
      .def_property_readonly("progress", &Job::progress, "Share of the work that is done, in [0, 1].")
      .def_property_readonly("stage", &Job::stage, "Name of the current stage; '' before the first one.")
      .def_property_readonly("cancelled", &Job::cancelled, "Whether `cancel` was called.")
      .def("cancel", &Job::cancel, "Ask the call to stop; within 50 ms it raises Cancelled.")
      .def("__repr__", [](const Job& job) {
        return py::str("<Job: {:.0%} {}{}>").format(job.progress(), job.stage(), job.cancelled() ? ", cancelled" : "");
      });
}

}  // namespace isimp::bindings
