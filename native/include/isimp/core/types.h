#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace isimp {

using Vec3 = Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;  ///< three vertex indices, counter-clockwise seen from outside

/// The place as float32 holds it. Coordinate by coordinate: where g++ 12 vectorises p.cast<float>().cast<double>(),
/// some coordinates keep their double precision.
inline Vec3 rounded_to_float(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// What stands for "none" where an index is expected: no neighbour, no region.
inline constexpr std::int32_t kNone = -1;

}  // namespace isimp
