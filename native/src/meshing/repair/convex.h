#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Cuts concave polygons by diagonals until none is left. Each cut ends at a reflex corner. The cut
/// with the fewest parts after it is made; among equals, the one that makes most reflex corners convex, then the one with
/// the widest angles. Corners keep their places, so a planar polygon leaves planar parts. A cut that would make a defect, or
/// join two corners that an edge joins already, is not made.
/// \return the number of cuts
/// Cost: O(n^2 log n) for a polygon of n corners and each cut, up to 64 n times that to count the parts, and a trial.
std::int32_t make_convex(State& state, Defects& defects, const Job& job);

/// The polygons that have a corner which is reflex, seen along the polygon's own normal.
std::int32_t count_concave(const State& state);

}  // namespace isimp::meshing
