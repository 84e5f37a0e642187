#pragma once

#include <cmath>

#include "isimp/core/types.h"

namespace isimp::detail {

/// The products added from x to z. Eigen adds in an order of its own choice, so results would depend on its version.
inline double dot(const Vec3& a, const Vec3& b) { return a.x() * b.x() + a.y() * b.y() + a.z() * b.z(); }
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

}  // namespace isimp::detail
