#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Some of the pieces, or all.
class Scope {
 public:
  [[nodiscard]] bool has(std::int32_t piece) const { return piece >= first_ || some_[piece]; }
  /// Leaves only pieces that are still to come.
  /// \param count  how many there are
  void clear(std::int32_t count) {
    first_ = count;
    some_.assign(count, false);
  }
  void add(std::int32_t piece) {
    if (piece < first_) some_[piece] = true;
  }

 private:
  std::int32_t first_ = 0;  // it and all after it
  std::vector<bool> some_;  // before that
};

/// Gives corners the freedom back that the repair took beyond need: those that were pulled back get all of their
/// radius, and those that `Complex::bend` added are dropped, all at once; then the corners of every polygon that became
/// faulty are made what they were, until there is none. Those that suffered for the sake of others get another chance
/// in a few turns, each with a share of them.
/// \param scope  corners of other pieces stay as they are
/// Cost: some twenty rounds of `State::update` and `Findings::judge`, each for what the one before changed.
void ease(State& state, Findings& findings, const Scope& scope, Job& job);

/// Makes corners of vertices that are none, and drops those that are, all at once; then the corners of every polygon that
/// became faulty are made what they were, until there is none.
/// \param vertices  on boundaries of pieces; corners that have to be stay
/// Cost: as one turn of `ease`.
void turn_corners(State& state, Findings& findings, std::span<const std::int32_t> vertices, Job& job);

}  // namespace isimp::meshing
