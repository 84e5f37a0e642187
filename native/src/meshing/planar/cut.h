// Cuts polygons that are to be planar.
#pragma once

#include <cstdint>
#include <vector>

#include "planar/draft.h"

namespace isimp::meshing::planar {

/// Cuts the waiting units of a draft, and rebuilds their polygons. Corners off the plane of a unit are cut off by as few
/// triangles as possible. The rest stays one polygon, or a few. No cut joins two corners that an edge joins already.
/// \param thickness  scene units: a thinner triangle has no area
/// \return their charts, in rising order
/// Cost: O(n^3) for each unit of n corners.
std::vector<std::int32_t> renew_cuts(Draft& draft, double thickness);

}  // namespace isimp::meshing::planar
