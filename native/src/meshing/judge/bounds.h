#pragma once

#include "complex/state.h"
#include "judge/judge.h"

namespace isimp::meshing {

/// The bounds of the judge. With fewer regions than `flatness_from` the bound on planarity is wider, so that the number
/// of polygons does not jump between two numbers of regions. It is at least the tolerance of the partition.
Bounds bounds_of(const State& state);
/// \param regions, tolerance  of the partition
/// \param diagonal  of the scan
Bounds bounds_of(const MeshingOptions& options, std::int32_t regions, double tolerance, double diagonal);

}  // namespace isimp::meshing
