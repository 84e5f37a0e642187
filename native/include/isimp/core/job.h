#pragma once

#include <atomic>
#include <functional>

namespace isimp {

/// State shared by a long call and its caller: progress and stage for the caller, the wish to stop for the call.
///
/// `progress`, `stage`, `cancelled`, `cancel` and `poll` may be called from any thread at any time; the rest belongs to
/// the thread that called. Precedence, when several things are true at once:
///  1. bad input is reported as InvalidInput even when the job was cancelled before the call;
///  2. a cancel that is seen at a poll throws Cancelled, independent of the result;
///  3. a cancel that comes after the last poll changes nothing: the result is returned.
/// A cancelled job stays cancelled: a new call needs a new Job. Progress never falls during the life of a Job.
class Job {
 public:
  Job() = default;
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  /// The finished share, in [0, 1].
  [[nodiscard]] double progress() const noexcept { return progress_.load(std::memory_order_relaxed); }
  /// The current stage in one or two lower-case words ("flooding"); "" before the first stage.
  [[nodiscard]] const char* stage() const noexcept { return stage_.load(std::memory_order_relaxed); }

  /// Throws Cancelled if the job was cancelled. Must be called at least every 50 ms.
  void poll() const;
  /// Called at every poll, by the polling thread, before the check for a cancel. Must be set before the work begins.
  std::function<void()> at_poll;
  /// Polls, and sets progress to `fraction` in [0, 1] of the present Stage (of the whole job outside any Stage).
  void report(double fraction);

  /// Names a stage and maps the reports made during its life to [from, to] of the Stage around it. Stages nest. The
  /// constructor polls; the destructor sets progress to the end of the stage.
  class Stage {
   public:
    /// \param stage  a string literal: it is kept as a pointer
    Stage(Job& job, const char* stage, double from, double to);
    ~Stage();
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

   private:
    Job& job_;
    const char* outer_stage_;
    double outer_from_, outer_to_;
  };

 private:
  void advance(double progress) noexcept;

  std::atomic<bool> cancelled_{false};
  std::atomic<double> progress_{0.0};
  std::atomic<const char*> stage_{""};
  double from_ = 0.0, to_ = 1.0;  // the present Stage's share of the whole job
};

}  // namespace isimp
