// Checks the input of polygonize.
#pragma once

#include "isimp/mesh/mesh.h"
#include "isimp/meshing/options.h"
#include "isimp/partition/partition.h"

namespace isimp::meshing {

/// \throws InvalidInput  the partition is not one of this mesh, or has a plane that is not finite; an option out of its
///                       range
void check_input(const Mesh& mesh, const Partition& partition, const MeshingOptions& options);

}  // namespace isimp::meshing
