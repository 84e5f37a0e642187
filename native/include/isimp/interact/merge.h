// Merges and splits regions.
#pragma once

#include <span>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Merges the region of `other` into the region of `face`. No other face changes its region.
///
/// The merged region has the number of the region of `face`; the numbers above the other's decrease by one.
/// \throws InvalidInput  a face outside [0, F) or left out; both in one region; the two regions share no edge, or only
///                       barriers; one of them is locked
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else the size of the other's region.
Partition merge_regions(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t other, Job& job);

/// Splits the region of a face into the two parts with the most different normals; a flat one half-way along its
/// length.
///
/// The part without the face is the new region, R; the border between the two is relaxed, no other face changes its
/// region.
/// \throws InvalidInput  a face outside [0, F) or left out; its region is a single face, or locked
/// \throws Cancelled     nothing was changed
/// Cost: O(F) to copy the labels, else the size of the region.
Partition split_region(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

/// Splits the region of a face along a line, as with a knife. The line is extended straight at both ends and swept
/// along a direction; the side of this curtain on which its centre lies decides the part of each face.
///
/// If this makes more than two pieces, the largest piece on the left is one part and the largest of the remaining
/// pieces is the other; all other pieces join the first part. The part without the face is the new region, R. Nothing
/// is relaxed: the cut stays where it was drawn. No other face changes its region.
/// \param line  (K) points, at least 2, in scene units
/// \param direction  of the sweep, such as the viewing direction; zero: the region's normal
/// \throws InvalidInput  as split_region; fewer than 2 points; a coordinate that is not finite; a line that is a point
///                   when seen along the direction; the whole region on one side
/// \throws Cancelled  nothing was changed
/// Cost: O(F) to copy the labels, else O(faces of the region * K).
Partition split_along(const Mesh& mesh, const Partition& partition, std::int32_t face, std::span<const Vec3> line,
                      const Vec3& direction, Job& job);

}  // namespace isimp
