#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Moves corners onto the planes that `regularise` has snapped. Where a polygon would get a fault that it had not, or
/// would meet another one, planes round it are let go, the smallest first; a corner that no snapped plane is left at is
/// where it was. So no fault is added, and polygons stay the same but for their corners' places.
/// \param findings  of the state as it is; up to date afterwards
/// \return the regions whose planes were let go, in rising order
/// Cost: O(rounds * options.flatten * corners), for the corners round what was let go in the round before.
std::vector<std::int32_t> keep_to_planes(State& state, Findings& findings, const Job& job);

}  // namespace isimp::meshing
