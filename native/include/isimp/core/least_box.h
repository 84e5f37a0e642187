#pragma once

#include <Eigen/Core>
#include <vector>

namespace isimp::detail {

/// Returns the rotation after which points have the axis-parallel box of least area. An edge of their convex hull is
/// parallel to an axis then. Without such an edge it is the identity.
/// Cost: O(N log N + H^2) for N points, H of them corners of the hull.
/// Source: Freeman, Shapira 1975.
Eigen::Matrix2d least_box_turn(const std::vector<Eigen::Vector2d>& points);

}  // namespace isimp::detail
