#pragma once

#include <vector>

#include "components.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/surface.h"

/// The last step of every way of finding regions.
namespace isimp {

/// The result for callers: by face of the mesh and in scene units.
/// \param history  errors as shares of the whole surface's area
Partition make_partition(const Surface& surface, const Components& components, const Regions& regions,
                         std::vector<double> history, const Threads& threads, Job& job);

/// Measures the error from the normals there are, which with a bound need not be the mean ones.
void restate_error(const FaceGraph& graph, Partition& part);

/// Copies the values that determined the number of regions: bound, tolerance, noise.
void take_how_found(Partition& part, const Partition& before);

}  // namespace isimp
