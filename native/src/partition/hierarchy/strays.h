#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hierarchy/contraction.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// Makes every cluster of patches connected. The largest piece of a cluster keeps its number. Every other piece joins
/// the cluster around it with the least cost, ties to the lower number.
///
/// A tree of merges stores the adjacency of patches at the time when it was made. Where the borders of patches move
/// later, two merged patches may be apart.
/// \param touching  pairs of patches that share an edge now; its sums are not read
/// \param sum       (N) of the patches
/// \param cluster   (N) of each patch, in [0, clusters)
/// \return number of pieces that have moved
/// Cost: O(N + pairs that touch).
std::int32_t join_strays(const MergeGraph& touching, std::span<const RegionSum> sum, std::int32_t clusters,
                         std::vector<std::int32_t>& cluster);

}  // namespace isimp
