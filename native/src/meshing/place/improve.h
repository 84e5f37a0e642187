#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Moves the corners of polygons that have changed since the last call to better places. All targets are found at once,
/// as `State::update` places corners. Then the corners move there as far as polygons stay sound (moves.h).
/// Cost: that of `move_corners`.
void improve_places(State& state, Defects& defects, Job& job);

/// Moves all corners to the places of least energy near where they are, as far as polygons stay sound.
/// Cost: that of `move_corners`.
void settle_places(State& state, Defects& defects, Job& job);

}  // namespace isimp::meshing
