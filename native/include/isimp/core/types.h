#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace isimp {

using Vec3 = Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;  ///< three vertex indices, counter-clockwise seen from outside

/// What stands for "none" where an index is expected: no neighbour, no region.
inline constexpr std::int32_t kNone = -1;

}  // namespace isimp
