#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <utility>

#include "isimp/core/job.h"

namespace isimp::bindings {

namespace py = pybind11;

/// Does work(job) without the GIL, with a job of its own if None was given, and returns what it returns.
///
/// The work runs on another thread while this one looks for signals, since Python's handlers run on its main thread
/// only: so Ctrl-C cancels the job, and the call ends with KeyboardInterrupt once the work has stopped.
template <class Work>
auto call(Job* given, Work&& work) {
  Job own;
  Job& job = given != nullptr ? *given : own;
  const py::gil_scoped_release released;
  auto result = std::async(std::launch::async, [&] { return work(job); });
  while (result.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() == 0) continue;
    const py::error_already_set interrupt;
    job.cancel();
    {
      const py::gil_scoped_release again;
      result.wait();
    }
    throw interrupt;
  }
  return result.get();
}

}  // namespace isimp::bindings
