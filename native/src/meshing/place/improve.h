#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Moves the corners of polygons that have changed since the last call to better places. All targets are found at once,
/// as `State::update` places corners. Then one corner after another moves there, all the way or a part of it, if no
/// polygon at the corner gets a fault or meets another by that. Sound polygons stay sound, so no move is undone later.
/// Cost: `Findings::accepts` up to three times a corner.
void improve_places(State& state, Findings& findings, Job& job);

}  // namespace isimp::meshing
