#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Slides corners where the planes of the adjacent charts leave them free: along the edge of two planes, or anywhere in
/// one. Each corner moves to the best of several places near it: the one where the corners of its polygons are least
/// reflex and sharp, in degrees, so that zigzags become straight, as far as polygons stay sound. Most corners stay.
/// Cost: O(corners at such polygons), and that of `move_corners`.
void slide_corners(State& state, Defects& defects, Job& job);

}  // namespace isimp::meshing
