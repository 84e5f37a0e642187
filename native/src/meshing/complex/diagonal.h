// The best diagonal of a polygon.
#pragma once

#include <array>
#include <cstdint>

#include "complex/state.h"

namespace isimp::meshing {

/// The diagonal of a polygon that leaves the flattest two polygons, both facing as `normal`, as two vertices of the
/// mesh; kNone where all ends are joined already.
/// Cost: O(n^3) for n corners.
[[nodiscard]] std::array<std::int32_t, 2> best_diagonal(const State& state, std::int32_t polygon, const Vec3& normal);

}  // namespace isimp::meshing
