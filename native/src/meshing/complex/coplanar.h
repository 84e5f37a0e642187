#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"

namespace isimp::meshing {

/// Unites neighbouring charts of different regions that lie in one plane, as the parts of a flat wall do where regions
/// end in the middle of it. This saves the trials whether they can be one polygon. A region keeps its first chart. A
/// united chart need not be a disc, and the outlines and planes of charts are out of date.
/// \param labels  of the state
/// Cost: O(F).
void join_coplanar(const State& state, Labels& labels, const Job& job);

}  // namespace isimp::meshing
