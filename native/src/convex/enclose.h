#pragma once

#include <span>
#include <vector>

#include "cell.h"
#include "hull.h"

namespace isimp::convex {

/// The space below some planes, in a box.
/// \param most_vertices  planes after which there would be more are left out
ConvexPart space_below(const std::vector<Plane>& planes, const Vec3& low, const Vec3& high, double snap,
                       std::int32_t most_vertices);

/// Moves planes of convex parts outwards, the least possible, until each point is in a part. Exact.
///
/// \param same           planes of facets whose corners are this near become one
/// \param most_vertices  of each part: planes that cut off least are left out
void enclose(std::vector<ConvexPart>& parts, std::span<const Vec3> points, double same, std::int32_t most_vertices,
             Job& job);

}  // namespace isimp::convex
