#pragma once

#include <span>

#include "isimp/partition/partition.h"

namespace isimp {

/// Locks the regions of some faces, leaves them out or unlocks them. Edits do not change the faces of a locked region:
/// edits at a neighbour neither take faces from it nor add faces to it, and edits of the region itself are refused,
/// except painting onto it. A region that is left out is locked, and `polygonize` makes no polygon of it, or a box of all
/// adjacent ones.
///
/// \param lock  kLocked, which keeps kLeftOut or kBoxed of a region that has it; kLeftOut; kBoxed; 0 unlocks
/// \param faces  indices into mesh.triangles(), several may be of one region
/// \throws InvalidInput  no face; a face outside [0, F) or left out; the partition is not one of this mesh
/// Cost: O(F) to copy the labels.
Partition set_locked(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces,
                     std::uint8_t lock);

}  // namespace isimp
