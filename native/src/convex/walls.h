#pragma once

#include <span>
#include <vector>

#include "isimp/convex/convex_parts.h"
#include "solid.h"

namespace isimp::convex {

/// Slabs behind the polygons of an open surface, whose front sides are the polygons. Slabs of polygons that share an
/// edge meet in the plane halfway between them, so that they neither overlap nor leave a gap. A slab ends where another
/// polygon lies behind it, and halfway where that one faces the same way, as there is free space between them.
///
/// Notches and holes of a region are filled where nothing of them can be seen from the front.
///
/// \param region     as of `convex_parts`
/// \param origin     is subtracted from all vertices
/// \param thickness  the most, scene units
/// \return relative to the origin
std::vector<ConvexPart> walls_of(const PolygonSoup& polygons, std::span<const std::int32_t> region, const Vec3& origin,
                                 const Solid& solid, double thickness, std::int32_t most_vertices, Job& job);

}  // namespace isimp::convex
