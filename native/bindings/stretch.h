#pragma once

#include <optional>

#include "isimp/core/job.h"

namespace isimp::bindings {

/// A Job::Stage for a `with` statement.
class Stretch {
 public:
  Stretch(Job& job, double begin, double end) : job_(job), begin_(begin), end_(end) {}
  void enter() { stage_.emplace(job_, "meshing", begin_, end_); }
  void exit() { stage_.reset(); }

 private:
  Job& job_;
  double begin_, end_;
  std::optional<Job::Stage> stage_;
};

}  // namespace isimp::bindings
