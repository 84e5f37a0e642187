// Points, triangles and indices.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace isimp {

using Vec3 = Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;  ///< three vertex indices, counter-clockwise seen from outside

/// The place rounded to float32. By way of `volatile`, since g++ 12 at -O3 drops casts of several doubles to float and
/// back where it vectorises them.
inline Vec3 rounded_to_float(const Vec3& p) {
  const auto rounded = [](double x) {
    const volatile auto narrow = static_cast<float>(x);
    return static_cast<double>(narrow);
  };
  return {rounded(p.x()), rounded(p.y()), rounded(p.z())};
}

/// mark: the index that means "none": no neighbour, no region.
inline constexpr std::int32_t kNone = -1;

}  // namespace isimp
