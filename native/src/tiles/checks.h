#pragma once

#include "isimp/tiles/merge.h"

namespace isimp::tiles {

/// \throws InvalidInput  a pair of nodes out of range
void check_pairs(const JoinedGraph& graph);
/// \throws InvalidInput  not one component for each node, or a component out of range
void check_components(const JoinedGraph& graph, const Components& components);

}  // namespace isimp::tiles
