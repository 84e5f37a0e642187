#pragma once

#include "isimp/core/job.h"
#include "state.h"

namespace isimp::meshing {

/// Makes pieces of different regions one that lie side by side in one plane, as a flat wall does where regions end in
/// the middle of it. Then nobody need try whether they can be one polygon. A region keeps its first piece. What comes of
/// it need not be a disc, and the outlines and planes of pieces are out of date.
/// Cost: O(F).
void join_coplanar(State& state, const Job& job);

}  // namespace isimp::meshing
