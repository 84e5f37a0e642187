// The edits of the thesis: adds and deletes regions.
#pragma once

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Starts a new region at a face, as the thesis's `add`.
///
/// The new region is R, the last one; all others keep their numbers. If the face belongs to a part that was left out,
/// that part becomes one region. Only the region of the face and its neighbours change: mostly the region is split in
/// two; if the face lies on a rounded corner or edge, the new region cuts it off from all regions that meet there.
/// \param face  index into mesh.triangles()
/// \throws InvalidInput  face outside [0, F); its region is a single face; the partition is not one of this mesh
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else the size of the changed regions.
Partition add_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

/// Removes the region of a face, as the thesis's `del`; its faces are flooded by the regions around it.
///
/// The numbers above the deleted one decrease by one.
/// \throws InvalidInput  face outside [0, F) or left out; its region is the only one of its part
/// \throws Cancelled     nothing was changed
/// Cost: as add_proxy.
Partition delete_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

}  // namespace isimp
