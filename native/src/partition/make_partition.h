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

/// The error of a region as a share of the surface's area: by the mean normal, with a bound by the normal of the plane.
double region_error(const Partition& part, std::int32_t region);

/// Sets the error to that of the regions, where a bound was set after they were summed up.
void restate_error(const FaceGraph& graph, Partition& part);

/// Copies the values that determined the number of regions, and how they were found.
void take_how_found(Partition& part, const Partition& before);

}  // namespace isimp
