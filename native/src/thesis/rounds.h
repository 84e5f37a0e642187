// The methods in rounds of flooding and fitting.
#pragma once

#include "hierarchy/hierarchy.h"
#include "isimp/core/job.h"
#include "isimp/parallel/flooder.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Whether the method floods on a back end.
bool needs_flooder(const PartitionOptions& options);

/// Exactly options.proxies regions by rounds of flooding and fitting: lloyd, teleport, naive and queued.
/// \param hierarchy  a hierarchy for this surface and number, if the seeding is hierarchical; else an empty one
/// \param flooder    the surface on options.backend, where needs_flooder(options); else null
Partition in_rounds(const Surface& surface, const Hierarchy& hierarchy, parallel::Flooder* flooder,
                    const PartitionOptions& options, Job& job);

}  // namespace isimp
