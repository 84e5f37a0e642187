#pragma once

#include <cstdint>
#include <span>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// A corner, and the place to which it moves.
struct Move {
  std::int32_t corner;
  Vec3 to;
};

/// Moves corners: all at once if no polygon becomes defective by that, else one after another, all the way or a part of
/// it, wherever no polygon becomes defective. Sound polygons stay sound, so no move is undone later.
/// Cost: that of judging the polygons at the corners; if one becomes defective, up to three trials a corner in addition.
void move_corners(State& state, Defects& defects, std::span<const Move> moves, Job& job);

}  // namespace isimp::meshing
