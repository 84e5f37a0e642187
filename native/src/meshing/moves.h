#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "findings.h"
#include "isimp/core/job.h"
#include "state.h"

namespace isimp::meshing {

/// Corners that are moved all at once, and put back where that makes polygons faulty.
class Moves {
 public:
  Moves(State& state, Findings& findings, Job& job)
      : s_(state),
        findings_(findings),
        job_(job),
        faulty_(findings.faulty()),
        before_(state.corners.position.begin(), state.corners.position.end()) {}

  [[nodiscard]] const std::vector<Vec3>& before() const { return before_; }  ///< where the corners were
  /// To be called when corners have been moved: those of polygons that became faulty go back, and of more and more
  /// polygons round them, until none is.
  /// \param with  another corner that goes back with one, kNone for none
  /// Cost: some rounds of `Findings::judge`, each for what the one before changed.
  void settle(std::span<const std::int32_t> moved, const std::function<std::int32_t(std::int32_t)>& with);
  /// Judges what is round corners that have been moved: whether nothing has become faulty.
  [[nodiscard]] bool is_sound(std::span<const std::int32_t> moved);

 private:
  /// The pieces that have become faulty.
  [[nodiscard]] std::vector<std::int32_t> worse() const;
  void judge(std::span<const std::int32_t> corners);

  State& s_;
  Findings& findings_;
  Job& job_;
  const std::vector<bool> faulty_;  // by piece, before
  const std::vector<Vec3> before_;  // by corner
};

}  // namespace isimp::meshing
