#pragma once

#include <optional>

#include "isimp/core/job.h"

namespace isimp::bindings {

/// A Job::Part for a `with` statement.
class Stretch {
 public:
  Stretch(Job& job, double begin, double end) : job_(job), begin_(begin), end_(end) {}
  void enter() { part_.emplace(job_, "meshing", begin_, end_); }
  void exit() { part_.reset(); }

 private:
  Job& job_;
  double begin_, end_;
  std::optional<Job::Part> part_;
};

}  // namespace isimp::bindings
