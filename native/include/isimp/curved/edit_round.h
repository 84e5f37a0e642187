#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

/// Edits of curved patches. Each names a face of the mesh in the patch, and leaves all other regions as they are.
namespace isimp {

/// The patch that the region of a face is a cell of; kNone where it is none.
/// \throws InvalidInput  a face out of range
std::int32_t patch_of(const Mesh& mesh, const Partition& part, std::int32_t face);

/// Cuts a patch into another number of segments and rings.
/// \param rings  0: chosen for about as many cells as there are for each segment now. Cylinders, cones and extrusions
///               have 1, and so have patches with all faces at one place along the profile.
/// \throws InvalidInput  the face is in no patch, a cell of it is locked, segments or rings out of range
/// Cost: O(F).
Partition with_segments(const Mesh& mesh, const Partition& part, std::int32_t face, std::int32_t segments,
                        std::int32_t rings, Job& job);

/// Makes the cells of a patch ordinary regions: the labels stay, the planes are free.
/// \throws InvalidInput  the face is in no patch, a cell of it is locked
Partition explode_round(const Mesh& mesh, const Partition& part, std::int32_t face, Job& job);

/// Makes the regions of some faces one curved patch of as many cells.
/// \param kind  the kind of surface; none: the simplest that fits nearly as well as the best
/// \throws InvalidInput  no face, one out of range or in a part that was left out, a locked region, regions that are not
///                       connected, or faces that determine no such surface
/// Cost: O(F).
Partition make_round(const Mesh& mesh, const Partition& part, std::span<const std::int32_t> faces,
                     std::optional<CurvedKind> kind, Job& job);

}  // namespace isimp
