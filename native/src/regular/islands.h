#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "region_planes.h"

namespace isimp::regular {

/// Makes islands parts of their walls. An island is a region that is on the plane of a wall, a larger region, and that is
/// surrounded by the wall together with the regions of its rim. Island and rim become part of the wall where none of
/// their vertices is further than `depth` from its plane. The wall keeps its plane.
///
/// Locked regions stay, and so do those whose plane was set by hand or freed, unless it is the wall's; nothing is merged
/// across a barrier.
/// \param partition  as `regularise` snaps it: planes are where region_normal * x is region_offset
/// \param regions  (R) what a wall stands for grows by its islands
/// \return the numbers of the regions that stay, rising
/// Cost: O(F + R * islands).
std::vector<std::int32_t> merge_islands(const Mesh& mesh, Partition& partition, std::span<RegionPlane* const> regions,
                                        double depth);

}  // namespace isimp::regular
