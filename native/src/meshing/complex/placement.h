// Places corners by one energy.
#pragma once

#include <span>
#include <vector>

#include "complex/polygons.h"
#include "isimp/core/threads.h"

namespace isimp::meshing {

/// Sets how far each of the given corners may be moved from its mesh vertex: `reach`, and not much further than
/// its shortest edge is long.
void set_radii(const Polygons& polygons, const Mesh& mesh, double reach, std::span<const std::int32_t> moving,
               Corners& corners);

/// Moves the given corners towards the places of least energy:
///
///     sum over polygons: area * (mean square distance of the chart from the plane
///                                + bend * mean square distance of the corners from the plane)
///     + sum over corners: tie * area of a vertex * square distance from the place at the start
///
/// A vertex of the mesh has the mean area of all. With a tie of 1 a corner's vertex counts as much as any other vertex in
/// the plane of its chart. The area of a chart is shared among its polygons, that of a polygon among its corners. A turn finds the planes of
/// least energy for given corners, then the corners of least energy for given planes. Corners stay within their radii,
/// and do not move by less than `Corners::still`. The first turn begins with the planes of the charts.
///
/// Held planes do not change, and their corners lie on them, as far as these planes meet within the radius. A corner
/// among cells of round parts lies where their planes meet, though it is further off: with few segments it is outside
/// the scan. Its radius grows by that, unless it is 0.
/// Cost: O(corners) a turn, as the distance of a chart follows from its moments.
void place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
           std::span<const std::int32_t> moving, int rounds, const Threads& threads, Corners& corners);

}  // namespace isimp::meshing
