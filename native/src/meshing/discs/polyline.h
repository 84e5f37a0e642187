// Boundaries between charts as polylines.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "isimp/core/types.h"

namespace isimp::meshing {

/// The squared distance of a point from the segment between two others.
double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b);

struct Farthest {
  double distance;    ///< distance of a point from the segment between first and last; -1 if there are no more points
  std::size_t where;  ///< its index
};

/// The point of a polyline that is farthest from its chord; among nearly equal ones the point with the largest sum of
/// distances from both ends, so that a side parallel to the chord gives a corner of the shape and not a point between
/// two. The middle one where all lie on the chord.
/// Cost: O(n).
Farthest farthest(std::span<const Vec3> line);

/// Removes zigzag from a polyline; its ends and its bends stay: a point that turns against its neighbours is moved
/// towards the mean of the middles of its two edges.
void take_out_zigzag(std::span<Vec3> line);

/// Vector area between a line and its chord, walked along the line and back on the chord.
Vec3 area_left_out(std::span<const Vec3> line);

/// The points to keep between the ends so that no point is further than `reach` from the chord that stands for it; at
/// least one if the ends are the same point.
/// \return indices in rising order
/// Source: Douglas, Peucker 1973; then needless points are removed, and the others slide to the places of least misfit.
std::vector<std::size_t> simplify(std::span<const Vec3> line, double reach);

/// The points of a ragged line to keep between its ends, so that nine tenths of the line between two of them are within
/// `reach` of the straight line of least squares along it; at least one if the ends are the same point. Corners at these
/// points are to be moved to where such lines meet: the points themselves may be at its notches.
/// \return indices in rising order
std::vector<std::size_t> simplify_ragged(std::span<const Vec3> line, double reach);

}  // namespace isimp::meshing
