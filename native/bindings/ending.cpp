#include "ending.h"

#include <chrono>
#include <set>
#include <thread>

#include "isimp/core/errors.h"

namespace isimp::bindings {
namespace {

constexpr std::chrono::seconds kPatience{10};  // a job is polled every 50 ms, except while the system waits

/// All of it is guarded by the GIL. Never destroyed, since threads may outlive the interpreter.
struct Calls {
  std::set<Running*> running;
  bool ending = false;
  std::thread::id ended_by;
};

Calls& calls() {
  static auto* const all = new Calls;
  return *all;
}

void stop_calls() {
  calls().ending = true;
  calls().ended_by = std::this_thread::get_id();
  const auto latest = std::chrono::steady_clock::now() + kPatience;
  while (!calls().running.empty() && std::chrono::steady_clock::now() < latest) {
    for (Running* call : calls().running) call->cancel();
    const Unlocked unlocked;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace

Unlocked::~Unlocked() {
  try {
    PyEval_RestoreThread(state_);
  } catch (...) {  // only the unwinding that ends this thread
    while (true) std::this_thread::sleep_for(std::chrono::hours(1));
  }
}

Running::Running(Job& job) : job_(job) {
  if (calls().ending && calls().ended_by != std::this_thread::get_id()) throw Cancelled();
  calls().running.insert(this);
}

Running::~Running() { calls().running.erase(this); }

void stop_calls_at_the_end() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&stop_calls));
  const auto os = py::module_::import("os");
  if (py::hasattr(os, "register_at_fork"))  // a child has none of the threads that call
    os.attr("register_at_fork")(py::arg("after_in_child") = py::cpp_function([] { calls().running.clear(); }));
}

}  // namespace isimp::bindings
