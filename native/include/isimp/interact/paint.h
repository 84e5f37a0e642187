// Paints, erases, grows and shrinks regions.
#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Makes faces a region of their own, as a brush stroke does, or adds them to an existing region. Nothing is relaxed:
/// the border stays where it was drawn.
///
/// Pieces that the stroke cuts off from other regions are flooded by the regions around them, including the painted
/// one, so that every region stays connected. A region that is painted over completely is removed, and the numbers
/// above it decrease by one. Faces of locked regions do not change.
/// \param faces  (K) of mesh.triangles(), in any order, possibly repeated
/// \param onto   a face of the region that they join, which may be locked; kNone: a new region, the last one
/// \throws InvalidInput  no face left to paint; a face outside [0, F) or left out; the faces (with the region they
///                       join) are not connected: the message names one that is not; another mesh's partition
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else O(K log K) and the size of the pieces that are cut off.
Partition paint_faces(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces,
                      std::int32_t onto, Job& job);

/// Removes faces from the region of the first of them; the regions around flood them. Faces of other regions stay, so
/// that an eraser changes nothing beyond the border. Faces inside also stay if no other region is reached from them.
///
/// The region stays connected as by paint_faces. If all of it is erased, it is removed, and the numbers above it
/// decrease by one.
/// \throws InvalidInput  no face; a face outside [0, F); the region of the first is left out, locked, or has no
///                       neighbour next to these faces that is not locked
/// \throws Cancelled     nothing was changed
/// Cost: as paint_faces.
Partition erase_faces(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, Job& job);

/// Adds the adjacent faces to the region of a face, `rings` times. No region loses its last face.
/// \throws InvalidInput  a face outside [0, F) or left out; its region is locked, or has no neighbour to take from;
///                       `rings` is below 1
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else the size of the region.
Partition grow_region(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t rings, Job& job);

/// Removes the faces along its border from the region of a face, `rings` times. The regions around flood them.
/// \throws InvalidInput  as grow_region; nothing would be left of it
/// \throws Cancelled     nothing was changed
/// Cost: as grow_region.
Partition shrink_region(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t rings, Job& job);

}  // namespace isimp
