#pragma once

#include "complex/state.h"
#include "judge/judge.h"

namespace isimp::meshing {

/// What a polygon may be. Fewer regions than `flatness_from` may miss their planes by more, so that no number of regions
/// gives many more polygons than the one before. The bound on planarity is at least the tolerance of the partition.
Bounds bounds_of(const State& state);
/// \param regions, tolerance  of the partition
/// \param diagonal  of the scan
Bounds bounds_of(const MeshingOptions& options, std::int32_t regions, double tolerance, double diagonal);

}  // namespace isimp::meshing
