#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"

namespace isimp {

/// rounding: the default of `merge_flat`, in degrees: far below any angle that someone draws, above the rounding of float32.
inline constexpr double kFlatAngle = 0.01;

/// The result of `merge_flat`.
struct FlatMerge {
  PolygonMesh polygons;                   ///< `polygon_region` numbers the flat regions by their first face
  std::vector<std::int32_t> face_region;  ///< (F) the flat region of each face
};

/// Merges coplanar faces into polygons. Nothing else changes: vertices stay where they are, bit by bit.
///
/// Faces belong together if they are connected and each of them lies in the plane that the others have: its normal is
/// within `angle` of that of the plane, or all its corners within a millionth of the diagonal. A vertex inside a
/// polygon or on a straight border between two polygons, up to a millionth of the diagonal, is left out. A region with
/// holes becomes several polygons, cut along straight lines between its corners.
///
/// \param angle  degrees, in [0, 90]
/// \param group  (F) faces of different groups, such as materials, stay apart; empty: one group
/// \throws InvalidInput  the angle is out of its range; not F groups
/// \throws Cancelled     nothing was made
/// Cost: O(F log F) time, O(F) memory.
FlatMerge merge_flat(const Mesh& mesh, double angle, std::span<const std::int32_t> group, Job& job);

}  // namespace isimp
