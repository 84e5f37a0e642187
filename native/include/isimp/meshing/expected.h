#pragma once

#include <cstdint>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/options.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// The approximate number of polygons that `polygonize` will make, and the causes of those beyond the regions. The
/// counts add up.
struct ExpectedPolygons {
  std::int32_t polygons = 0;
  std::int32_t regions = 0;  ///< regions that have an area
  std::int32_t split_for_unconnected = 0, split_for_pinches = 0, split_for_holes = 0, split_for_handles = 0,
               split_for_closed = 0;  ///< polygons that the topology of the regions needs
  std::int32_t split_for_repair = 0;  ///< estimated number needed for flat, simple polygons that do not meet
};

/// Counts the polygons before they are made: one a region, the further ones that topology needs, and an estimate for
/// polygons that are bent, crossing or meeting at their first places.
///
/// \throws InvalidInput, Cancelled  as `polygonize`
/// Cost: about a fifth of `polygonize`. Error on scans: 3 % in the median; docs/trials.md has a table.
ExpectedPolygons expected_polygons(const Mesh& mesh, const Partition& partition, const MeshingOptions& options,
                                   Job& job);

}  // namespace isimp
