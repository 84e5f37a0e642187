#pragma once

#include <cstdint>
#include <vector>

#include "hierarchy/contraction.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"

namespace isimp {

/// Boundary relaxation one level up: whole patches move between neighbouring regions while that lowers the error plus a
/// weight for each pair of neighbours in different regions.
///
/// A patch leaves only if its neighbours of the same region hang together among themselves, so regions stay connected.
/// The result is the same on any number of threads (see Relaxation).
/// \param label  (N) region of each node; nodes with kNone are skipped
/// \param smooth  as in `optimise`
void relax_patches(const MergeGraph& graph, std::vector<std::int32_t>& label, std::int32_t regions, double smooth,
                   int sweeps, const Threads& threads, Job& job);

}  // namespace isimp
