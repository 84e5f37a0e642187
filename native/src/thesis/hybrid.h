#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// A surface with most of its faces collapsed: made once, partitioned at any number of regions.
///
/// Its vertices are some of the dense mesh's, where they were. Edges that are barriers stay.
struct Decimated {
  double fraction = 0.0;             ///< the requested share of faces
  std::vector<std::int32_t> vertex;  ///< (Vc) vertex of the dense mesh
  std::vector<Triangle> triangles;   ///< (Fc) of indices into `vertex`
};

/// Collapses edges, least quadric error first, down to `fraction` of the faces. It may end above that where another
/// collapse would turn a face over or change the topology.
///
/// \throws InvalidInput  a fraction outside (0, 1]
/// \throws Cancelled     nothing was changed
/// Cost: O(F log F) time, some 600 bytes a face of memory.
/// Source: Garland, Heckbert 1997, by OpenMesh.
Decimated decimate(const Surface& surface, double fraction, Job& job);

/// Partitions the coarse mesh and carries the proxies back to the dense one: Method::hybrid.
///
/// Each proxy moves to the dense face most like it at the corners of its coarse seed, and one flooding from there
/// labels the dense faces. With Connect::flood that is all, and the coarse mesh is partitioned by Method::lloyd, as in
/// the thesis. With Connect::repair it is partitioned by Method::hierarchy, and the borders are relaxed on the dense
/// mesh: less error in less time. Regions are as in the Partitioner: connected, and exactly as many. The error is that
/// on the dense mesh, and the only one in the history. Weights and barriers hold on both.
///
/// \param coarse   from decimate() of this surface
/// \param options  checked, with `proxies`
/// \throws InvalidInput  the coarse mesh has fewer faces than `proxies`
///
/// Source: the thesis's hybrid.
Partition hybrid(const Surface& surface, const Decimated& coarse, const PartitionOptions& options, Job& job);

}  // namespace isimp
