#pragma once

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"

namespace isimp::tiles {

/// The noise of a tile as a partition estimates it: standard deviation along the normal, scene units. Cost: O(V + F).
double noise(const Mesh& mesh, Job& job);

}  // namespace isimp::tiles
