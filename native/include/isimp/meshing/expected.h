#pragma once

#include <cstdint>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/options.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// About how many polygons `polygonize` will make, and why they are more than the regions. The reasons add up.
struct ExpectedPolygons {
  std::int32_t polygons = 0;
  std::int32_t regions = 0;  ///< those that have an area
  std::int32_t split_for_unconnected = 0, split_for_pinches = 0, split_for_holes = 0, split_for_handles = 0,
               split_for_closed = 0;  ///< what the topology of the regions needs
  std::int32_t split_for_repair = 0;  ///< what being flat, simple and apart will take: estimated
};

/// Counts the polygons before they are made: regions, what their topology needs, and what the polygons will take that
/// are bent, crossing or meeting as they are placed first.
///
/// \throws InvalidInput, Cancelled  as `polygonize`
/// Cost: about a fifth of `polygonize`. Error on scans: 3 % in the median; docs/trials.md has a table.
ExpectedPolygons expected_polygons(const Mesh& mesh, const Partition& partition, const MeshingOptions& options,
                                   Job& job);

}  // namespace isimp
