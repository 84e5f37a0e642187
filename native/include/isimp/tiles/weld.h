#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"

namespace isimp::tiles {

/// Which vertices on borders of tiles are one: each goes to the nearest place of an earlier tile that is at most
/// `length` away, and the nearer of two vertices of a tile that want the same place gets it.
///
/// \param points  (N) places, all of a tile in a row
/// \param tile    (N) of each, rising
/// \return (N) index of the point whose place each takes; its own index where it stays
/// \throws InvalidInput  arrays of unequal lengths, a tile that falls, a length that is not above 0
/// Cost: O(N) where few points are within the length of each other.
std::vector<std::int32_t> weld(std::span<const Vec3> points, std::span<const std::int32_t> tile, double length,
                               Job& job);

/// A point inside an edge on the border of a tile: a T-junction.
struct OnEdge {
  std::int32_t edge = 0, point = 0;
  double along = 0.0;  ///< in (0, 1), from the edge's first end
};

/// Points that lie on edges, at most `length` off, and further than that from both ends.
///
/// \param ends  (2 E) the ends of the edges, one after the other
/// \return by edge, then along it; none of a point whose place is an end of the edge
/// \throws InvalidInput  an odd number of ends, a length that is not above 0
/// Cost: O(E + N) where edges are of similar lengths.
std::vector<OnEdge> points_on_edges(std::span<const Vec3> ends, std::span<const Vec3> points, double length, Job& job);

}  // namespace isimp::tiles
