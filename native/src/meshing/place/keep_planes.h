#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Moves corners onto the planes that `regularise` has snapped and onto planes of cells of round parts, one region after
/// another, the largest first. If polygons are to be planar, only cells count, since other planes move then. The corners
/// of a region move onto its plane and the planes kept before, and those of its neighbours with them; if a polygon would
/// get a new defect or would meet another one, the region's own corners are tried alone. If that fails too, the corners
/// return, and the plane is released unless a second pass succeeds. So no defect is added, and only corners move.
/// \param defects  of the state as it is; up to date afterwards
/// \return the regions whose planes were released, in rising order
/// Cost: up to four times `State::move_onto` and `Defects::accepts` of the corners around each region.
std::vector<std::int32_t> keep_to_planes(State& state, Defects& defects, Job& job);

}  // namespace isimp::meshing
