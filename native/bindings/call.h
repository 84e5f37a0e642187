#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <utility>

#include "ending.h"
#include "isimp/core/job.h"

namespace isimp::bindings {

namespace py = pybind11;

/// Calls work(job) without the GIL, with a job of its own if None was given, and returns its result.
///
/// The work runs on another thread while this one checks for signals, since Python's handlers run on its main thread
/// only: so Ctrl-C cancels the job, and the call ends with KeyboardInterrupt once the work has stopped.
template <class Work>
auto call(Job* given, Work&& work) {
  Job own;
  Job& job = given != nullptr ? *given : own;
  const Running running(job);
  auto result = std::async(std::launch::async, [&] { return work(job); });
  const auto is_done = [&] {
    const Unlocked unlocked;
    return result.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
  };
  while (!is_done()) {
    if (PyErr_CheckSignals() == 0) continue;
    const py::error_already_set interrupt;
    job.cancel();
    {
      const Unlocked unlocked;
      result.wait();
    }
    throw interrupt;
  }
  return result.get();
}

/// As above on the caller's thread, for work of a few milliseconds.
template <class Work>
auto call_here(Job* given, Work&& work) {
  Job own;
  Job& job = given != nullptr ? *given : own;
  const Running running(job);
  const Unlocked unlocked;
  return work(job);
}

}  // namespace isimp::bindings
