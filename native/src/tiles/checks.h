// Checks of the graph of all tiles.
#pragma once

#include "isimp/tiles/merge.h"

namespace isimp::tiles {

/// \throws InvalidInput  a pair contains a node out of range
void check_pairs(const JoinedGraph& graph);
/// \throws InvalidInput  the number of components differs from the number of nodes, or a component is out of range
void check_components(const JoinedGraph& graph, const JoinedComponents& components);

}  // namespace isimp::tiles
