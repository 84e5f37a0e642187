#pragma once

#include <functional>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp::regular {

/// An operation on the planes of a partition. It may unite regions.
using OnPlanes = std::function<Partition(const Mesh& mesh, const Partition& partition)>;

/// Calls an operation with the components that have regions, as a mesh of their own, so that its result does not depend
/// on other components. Regions have the same numbers there.
/// \return its result, as a partition of the whole mesh
/// Cost: O(F), and that of the operation.
Partition on_kept_planes(const Mesh& mesh, const Partition& partition, const OnPlanes& operation, Job& job);

}  // namespace isimp::regular
