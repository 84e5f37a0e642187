#pragma once

#include <Eigen/Core>

namespace isimp::meshing {

using Vec2 = Eigen::Vector2d;

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace isimp::meshing
