#pragma once

#include <span>

#include "isimp/partition/partition.h"

namespace isimp {

/// Locks the regions of some faces, or unlocks them. Edits leave the faces of a locked region as they are: those at
/// neighbours take nothing from it and give nothing to it, and those at its own faces are refused, save for painting
/// onto it.
///
/// \param faces  indices into mesh.triangles(), several may be of one region
/// \throws InvalidInput  no face; a face outside [0, F) or left out; the partition is not one of this mesh
/// Cost: O(F) to copy the labels.
Partition set_locked(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, bool locked);

}  // namespace isimp
