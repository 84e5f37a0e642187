#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/mesh/io.h"

namespace isimp {

struct ConvexOptions {
  double tolerance = 0;    ///< largest depth of free space that a part may fill, scene units; 0: half a per cent
                           ///< of the diagonal
  std::int32_t parts = 0;  ///< the most parts; 0: as many as the tolerance needs
  std::int32_t most_vertices = 64;  ///< the most vertices of a part, at least 8
  double thickness = 0;             ///< walls behind an open surface, scene units; 0: the surface bounds a solid
};

/// A convex polyhedron. No vertex lies outside the plane of any triangle, by exact arithmetic.
struct ConvexPart {
  std::vector<Vec3> vertices;       ///< in the caller's coordinates
  std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside
  double volume = 0;
};

/// Cuts a solid into convex parts along the planes of its polygons.
///
/// No point of a part is farther than `tolerance` from the solid, unless `parts` forces it: wider free space stays free.
/// Plates thinner than .4 of the tolerance, or than .2 % of the diagonal if that is less, may be lost, and parts that lie
/// within the tolerance of another part are left out. Solids may overlap, cross themselves or lie in each other: a point
/// is inside if the surface winds around it at least once.
///
/// With `thickness`, the polygons are the fronts of walls: each becomes a slab behind it, or a few if it is concave. Slabs
/// of neighbours meet without a gap. A wall of which both sides are there is as thick as it is, if that is less.
///
/// \param polygons  closed surfaces of nearly planar polygons, facing outwards; with `thickness`, any that face free space
/// \param region    the region of each polygon: polygons of one region share a plane; empty: each has its own
/// \param enclosed  points that must be in a part: planes are pushed outwards for this, the least possible
/// \throws InvalidInput  an index, number or option out of its range; the surface is open where a part would begin, or
///                       encloses no volume: the message names the place
/// \throws Cancelled     nothing was made
///
/// Cost: about O(C (Q + C)) for Q polygons and C cells into which their planes cut the solid, C being about Q.
/// Sources: Thibault, Naylor 1987 (cells of a solid); Wei, Liu, Ling, Su 2022 (cuts by their gain).
std::vector<ConvexPart> convex_parts(const PolygonSoup& polygons, std::span<const std::int32_t> region,
                                     std::span<const Vec3> enclosed, const ConvexOptions& options, Job& job);

}  // namespace isimp
