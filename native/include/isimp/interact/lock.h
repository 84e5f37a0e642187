#pragma once

#include <span>

#include "isimp/partition/partition.h"

namespace isimp {

/// Locks the regions of some faces, or unlocks them. Edits do not change the faces of a locked region: edits at a
/// neighbour neither take faces from it nor add faces to it, and edits of the region itself are refused, except
/// painting onto it.
///
/// \param faces  indices into mesh.triangles(), several may be of one region
/// \throws InvalidInput  no face; a face outside [0, F) or left out; the partition is not one of this mesh
/// Cost: O(F) to copy the labels.
Partition set_locked(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, bool locked);

}  // namespace isimp
