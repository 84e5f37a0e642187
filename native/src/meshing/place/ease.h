#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

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

/// Drops the corners that `Complex::bend` added, one after another, wherever no polygon becomes defective.
/// \param scope  corners of other pieces stay
/// Cost: a trial (trials.h) for each.
void ease(State& state, Defects& defects, const Scope& scope, Job& job);

/// Toggles vertices between corner and no corner, one after another, wherever no polygon becomes defective.
/// \param vertices  on boundaries of pieces; required corners stay
/// Cost: a trial for each.
void turn_corners(State& state, Defects& defects, std::span<const std::int32_t> vertices, Job& job);

}  // namespace isimp::meshing
