#pragma once

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/simplify/constraints.h"
#include "isimp/simplify/partitioner.h"

namespace isimp {

/// Regions that mirror in a plane.
///
/// One half of the surface is split. A region at the plane merges with its image if that costs less than another region
/// would gain; else the plane is a border. The other half gets the labels of the closest faces to its mirror image;
/// parts of it without an image are split on their own. Borders are relaxed over the whole surface, and mirrored once
/// more, so that they mirror as far as the triangles allow.
///
/// \param options      without symmetry and bound. `proxies` is exact if joins at the plane allow it
/// \param constraints  without faces and locked regions
/// \param mirror       in the caller's coordinates; the function sets `regions`
/// Cost: about that of partitions of the halves, three times, and F searches for a closest face.
Partition symmetric_partition(const Partitioner& partitioner, const Surface& surface, const PartitionOptions& options,
                              const Constraints& constraints, const Mirror& mirror, Job& job);

/// The number of regions of a partition that mirror.
std::int32_t mirrored_regions(const Mesh& mesh, const Partition& partition, const Mirror& mirror);

}  // namespace isimp
