#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "complex/state.h"
#include "complex/transaction.h"
#include "isimp/core/job.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Corners that are moved all at once, and put back where that makes polygons faulty.
class Moves {
 public:
  Moves(State& state, Findings& findings, Job& job)
      : s_(state), findings_(findings), job_(job), faulty_(findings.faulty()), transaction_(state) {}

  /// The position of a corner before the moves.
  [[nodiscard]] const Vec3& before(std::int32_t corner) const { return transaction_.place_before(corner); }
  /// Ends the moves: restores the corners of polygons that became faulty, and of more and more rings of polygons at
  /// these, until none is faulty.
  /// \param with  the corner that is restored together with a given one, kNone for none
  /// Cost: some rounds of `Findings::judge`, each for corners restored in the last one.
  void settle(std::span<const std::int32_t> moved, const std::function<std::int32_t(std::int32_t)>& with);
  /// Ends the moves in place of `settle`: restores all corners if any polygon became faulty.
  /// \return whether the moves stay
  [[nodiscard]] bool keep_if_sound(std::span<const std::int32_t> moved);

 private:
  /// The pieces that have become faulty.
  [[nodiscard]] std::vector<std::int32_t> worse() const;
  void judge(std::span<const std::int32_t> corners);

  State& s_;
  Findings& findings_;
  Job& job_;
  const std::vector<bool> faulty_;  // by piece, before
  Transaction transaction_;
};

}  // namespace isimp::meshing
