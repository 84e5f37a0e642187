// Places corners where the planes of their charts meet.
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

/// Puts the given corners where the planes of the adjacent charts meet, by least squares from the mesh vertex;
/// directions in which the planes hardly fix a point are left out, and no corner is moved further than its radius.
/// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 4; the truncation as in Kobbelt et al. 2001.
void place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
           std::span<const std::int32_t> moving, const Threads& threads, Corners& corners);

/// Moves the given corners from their places onto the held planes of adjacent charts, as far as these planes meet and
/// the radius allows it. A corner among cells of round parts moves to the place where their planes meet, though it is
/// further off: with few segments it is outside the scan. Its radius grows by that, unless it is 0.
void place_on_held(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
                   std::span<const std::int32_t> moving, const Threads& threads, Corners& corners);

/// Makes the polygons at the given corners flat by turns. A turn fits a plane to each polygon, then moves each corner
/// past the mean of its projections on the planes at the corner, within its radius. Flat polygons do not move.
void flatten(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
             std::span<const std::int32_t> moving, int rounds, const Threads& threads, Corners& corners);

}  // namespace isimp::meshing
