#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Moves corners onto the planes that `regularise` has snapped. If a polygon would get a new fault or would meet
/// another one, the smallest adjacent snapped plane is released. Corners without a snapped plane return to their old
/// position. So no fault is added, and only the positions of corners change.
/// \param findings  of the state as it is; up to date afterwards
/// \return the regions whose planes were released, in rising order
/// Cost: O(rounds * options.flatten * corners), for the corners at planes released in the round before.
std::vector<std::int32_t> keep_to_planes(State& state, Findings& findings, const Job& job);

}  // namespace isimp::meshing
