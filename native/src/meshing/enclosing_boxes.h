#pragma once

#include "isimp/meshing/polygonize.h"

namespace isimp::meshing {

/// Adds a box for each group of adjacent regions that boxes replace. A box stands on the neighbour with the longest
/// common border, or without a neighbour on its own largest region, and its footprint there has the least area. Its six quads are of the group's lowest region, after all
/// other polygons. The report counts them.
/// Cost: O(F + N log N) for the N vertices of such regions.
void add_enclosing_boxes(const Mesh& mesh, const Partition& partition, PolygonMesh& polygons);

}  // namespace isimp::meshing
