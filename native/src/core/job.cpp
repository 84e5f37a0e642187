#include "isimp/core/job.h"

#include <algorithm>

#include "isimp/core/errors.h"

namespace isimp {

void Job::poll() const {
  if (at_poll) at_poll();
  if (cancelled()) throw Cancelled();
}

void Job::advance(double progress) noexcept {
  progress_.store(std::max(this->progress(), std::clamp(progress, 0.0, 1.0)), std::memory_order_relaxed);
}

void Job::report(double fraction) {
  poll();
  advance(from_ + (to_ - from_) * std::clamp(fraction, 0.0, 1.0));
}

Job::Stage::Stage(Job& job, const char* stage, double from, double to)
    : job_(job), outer_stage_(job.stage()), outer_from_(job.from_), outer_to_(job.to_) {
  job.poll();
  const double width = outer_to_ - outer_from_;
  job.from_ = outer_from_ + width * std::clamp(from, 0.0, 1.0);
  job.to_ = outer_from_ + width * std::clamp(to, 0.0, 1.0);
  job.stage_.store(stage, std::memory_order_relaxed);
  job.advance(job.from_);
}

Job::Stage::~Stage() {
  if (!job_.cancelled()) job_.advance(job_.to_);
  job_.from_ = outer_from_;
  job_.to_ = outer_to_;
  job_.stage_.store(outer_stage_, std::memory_order_relaxed);
}

}  // namespace isimp
