#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/merging.h"

namespace isimp {

/// Boundary relaxation one level up: whole patches move between neighbouring regions while that lowers the error.
///
/// A patch leaves only if its neighbours of the same region hang together among themselves, so regions stay connected.
/// \param label  (N) region of each node; kNone takes no part
void relax_patches(const MergeGraph& graph, std::vector<std::int32_t>& label, std::int32_t regions, int sweeps,
                   Job& job);

}  // namespace isimp
