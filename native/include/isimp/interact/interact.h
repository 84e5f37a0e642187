#pragma once

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Starts a new region at a face, as the thesis's `add`.
///
/// The new region is R, the last one; all others keep their numbers. A face of a part that was left out brings that
/// part back as one region. Only the region of the face and those around it change: mostly its region is split in two;
/// where the face lies on a corner or an edge that was rounded, the new region cuts that off from all that meet there.
/// \param face  index into mesh.triangles()
/// \throws InvalidInput  face outside [0, F); its region is a single face; the partition is not one of this mesh
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else of the size of the regions touched.
Partition add_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

/// Removes the region of a face, as the thesis's `del`; its faces are flooded by the regions around it.
///
/// Regions above the deleted one move down by one number.
/// \throws InvalidInput  face outside [0, F) or left out; its region is the only one of its part
/// \throws Cancelled     nothing was changed
/// Cost: as add_proxy.
Partition delete_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

}  // namespace isimp
