#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"

namespace isimp::tiles {

/// Matches vertices on borders of tiles. Each vertex moves to the nearest place of an earlier tile, at most `length`
/// away. If two vertices of a tile have the same nearest place, only the nearer one moves.
///
/// \param points  (N) places, in the order of their tiles
/// \param tile    (N) tile of each point, rising
/// \return (N) index of the point whose place each point takes; its own index if it stays
/// \throws InvalidInput  arrays of unequal lengths, a tile that falls, a length that is not above 0
/// Cost: O(N) if few points are within the length of each other.
std::vector<std::int32_t> weld(std::span<const Vec3> points, std::span<const std::int32_t> tile, double length,
                               Job& job);

/// A point inside an edge on the border of a tile: a T-junction.
struct OnEdge {
  std::int32_t edge = 0, point = 0;
  double along = 0.0;  ///< in (0, 1), from the edge's first end
};

/// Finds points on edges: at most `length` from the edge, and further than that from both of its ends.
///
/// \param ends  (2 E) the ends of the edges, one after the other
/// \return by edge, then along it
/// \throws InvalidInput  an odd number of ends, a length that is not above 0
/// Cost: O(E + N) if edges are of similar lengths.
std::vector<OnEdge> points_on_edges(std::span<const Vec3> ends, std::span<const Vec3> points, double length, Job& job);

}  // namespace isimp::tiles
