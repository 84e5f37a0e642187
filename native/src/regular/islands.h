#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "region_planes.h"

namespace isimp::regular {

/// Makes islands parts of their walls. An island is a region on the plane of a larger region, the wall, that is
/// surrounded by the wall together with the regions of its rim. Island and rim become part of the wall if none of their
/// vertices is further than `depth` from its plane. The wall keeps its plane.
///
/// Locked regions stay, and so do regions whose plane was set by hand or freed, unless it is the wall's; nothing is
/// merged across a barrier.
/// \param partition  as snapped by `regularise`: planes are region_normal * x = region_offset
/// \param regions  (R) the entry of a wall grows by its islands
/// \return the numbers of the regions that stay, rising
/// Cost: O(F + R * islands).
std::vector<std::int32_t> merge_islands(const Mesh& mesh, Partition& partition, std::span<RegionPlane* const> regions,
                                        double depth, const Job& job);

}  // namespace isimp::regular
