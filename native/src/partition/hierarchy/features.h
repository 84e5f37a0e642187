#pragma once

#include <span>

#include "hierarchy/dendrogram.h"

namespace isimp {

/// Whether a cut at a cost loses no feature that a cut at the limit shows: a region that is turned far from the largest
/// one that it joins, and that costs more than twice the limit.
///
/// A gap of the costs above the limit is taken for bulges, dents and rounded edges, which lean on the adjacent planes.
/// The sides of a chimney cost as little, since they are small, but they stand on the roof.
/// \param leaves  the sums of the leaves, areas as shares of the whole
/// \param limit, cost  as shares of the whole area, as the costs of the tree
/// Cost: O(leaves).
bool keeps_features(const MergeTree& tree, std::span<const RegionSum> leaves, double limit, double cost);

}  // namespace isimp
