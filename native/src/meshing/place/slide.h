#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Lets corners slide where the planes of the pieces round them leave them free: along the edge of two planes, or
/// anywhere in one. A corner goes to the place, of some round it, where reflex and sharp corners of the polygons there
/// are fewest, counted in degrees, so that zigzags become straight; most corners stay. What becomes faulty goes back.
/// Cost: O(corners at such polygons), and some rounds of `Findings::judge` for what moves.
void slide_corners(State& state, Findings& findings, Job& job);

}  // namespace isimp::meshing
