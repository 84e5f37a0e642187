#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Makes faces a region of their own, as a brush stroke does, or part of a region there is. Nothing is relaxed: what is
/// painted stays as it was drawn.
///
/// What the stroke cuts off from the regions it goes over is flooded by those around it, the painted one among them, so
/// that every region stays connected; one that is painted over wholly is gone, and those above it move down by one.
/// Faces of locked regions stay as they are.
/// \param faces  (K) of mesh.triangles(), in any order, any of them several times
/// \param onto   a face of the region that they become part of, which may be locked; kNone: a new region, the last one
/// \throws InvalidInput  no face left to paint; a face outside [0, F) or left out; the faces (with the region they
/// become
///                       part of) do not hang together: the message names one that does not; another mesh's partition
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else O(K log K) and the size of what is cut off.
Partition paint_faces(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces,
                      std::int32_t onto, Job& job);

/// Takes faces from the region of the first of them; the regions around flood them. Faces of other regions stay, as an
/// eraser that goes beyond the border changes nothing there, and so do faces inside that no other region is reached
/// from.
///
/// The region stays connected as by paint_faces; erased wholly it is gone, and those above it move down by one.
/// \throws InvalidInput  no face; a face outside [0, F); the region of the first is left out, locked, or has no
/// neighbour
///                       that is not locked beside these faces
/// \throws Cancelled     nothing was changed
/// Cost: as paint_faces.
Partition erase_faces(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, Job& job);

/// Lets the region of a face take the faces beside it, `rings` times over. No region gives its last face.
/// \throws InvalidInput  a face outside [0, F) or left out; its region is locked, or has no neighbour to take from;
/// rings
///                       below 1
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else of the size of the region.
Partition grow_region(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t rings, Job& job);

/// Lets the region of a face give the faces along its border to those around it, `rings` times over.
/// \throws InvalidInput  as grow_region; nothing would be left of it
/// \throws Cancelled     nothing was changed
/// Cost: as grow_region.
Partition shrink_region(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t rings, Job& job);

}  // namespace isimp
