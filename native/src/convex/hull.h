#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "isimp/convex/convex_parts.h"
#include "isimp/core/types.h"

namespace isimp::convex {

/// Convex hull of points, by adding the farthest one first. Convex by exact arithmetic.
///
/// \param tolerance      points that are at most this far outside are left out
/// \param grid           0, or a power of two: all coordinates are multiples of it, and no two differ by more than 2^20
///                       of it, so that exact arithmetic is that of integers
/// \param most_vertices  of the hull; where it is reached, more points stay outside
/// \return no vertices if all points lie in a plane
/// Source: Barber, Dobkin, Huhdanpaa 1996.
ConvexPart hull_of(std::span<const Vec3> points, double tolerance, double grid = 0,
                   std::int32_t most_vertices = std::numeric_limits<std::int32_t>::max());

/// The same, and no vertex sticks out by less than the tolerance from the hull of all others.
ConvexPart simple_hull_of(std::span<const Vec3> points, double tolerance, std::int32_t most_vertices);

}  // namespace isimp::convex
