#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Undoes splits that are not needed: unites split charts with neighbours, wherever no polygon becomes defective by it.
/// Neighbours of the same region come first. A neighbour of another region must be at least as large and near the same
/// plane, and the region that loses the chart must keep another. A part that is not connected with the rest of its
/// region stays in the region. One change is tried after another (trials.h), the most promising first: unions whose
/// charts share most of their boundary. Then corners get better places, and corners that the repair added are dropped.
/// \param usual  of the regions: a union of two regions may add a share of it
/// Cost: a trial for each pair of adjacent charts that may be united.
void coarsen(State& state, Defects& defects, const Scale& usual, Job& job);

}  // namespace isimp::meshing
