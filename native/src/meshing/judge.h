#pragma once

#include "isimp/meshing/polygonize.h"

namespace isimp::meshing {

/// Fills in what the report says of edges and fans: closed, manifold, euler.
void judge_topology(PolygonMesh& mesh);

}  // namespace isimp::meshing
