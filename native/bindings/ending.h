// The end of Python while calls of the engine run.
#pragma once

#include <pybind11/pybind11.h>

#include "isimp/core/job.h"

namespace isimp::bindings {

namespace py = pybind11;

/// Releases Python's lock (the GIL) during its life.
///
/// When the interpreter ends while another thread is in here, Python ends that thread as it requests the lock, by
/// unwinding its stack on some systems, which no destructor may let through. Such a thread stays here until the process
/// ends.
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

/// A call that is under way, so that it can be stopped when the interpreter ends. Made and ended with the lock held.
class Running {
 public:
  /// \throws Cancelled  the interpreter is about to end, and this is not the thread that ends it
  explicit Running(Job& job);
  ~Running();
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  void cancel() { job_.cancel(); }

 private:
  Job& job_;
};

/// From now on, calls that are running when the interpreter ends are cancelled and waited for, so that no thread works
/// with objects that are being destroyed.
void stop_calls_at_the_end();

}  // namespace isimp::bindings
