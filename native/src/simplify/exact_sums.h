#pragma once

#include <cmath>

#include "isimp/core/types.h"

namespace isimp::detail {

/// Sums in a fixed order, which Eigen leaves open. The order is that of numpy's einsum and norm, which so give the same
/// bits.
inline double dot(const Vec3& a, const Vec3& b) { return a.x() * b.x() + a.z() * b.z() + a.y() * b.y(); }
inline double norm(const Vec3& a) { return std::sqrt(a.x() * a.x() + a.y() * a.y() + a.z() * a.z()); }

}  // namespace isimp::detail
