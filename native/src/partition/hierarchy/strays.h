#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hierarchy/contraction.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// Makes every cluster of patches connected. The largest piece of a cluster keeps its number. Every other piece joins
/// the cluster around it that costs least, ties to the lower number.
///
/// A tree of merges knows which patches touched when it was made. Where the borders of patches move later, two patches
/// that have merged may be apart.
/// \param touching  which patches share an edge now; its sums are not read
/// \param sum       (N) of the patches
/// \param cluster   (N) of each patch, in [0, clusters)
/// \return pieces that have moved
/// Cost: O(N + pairs that touch).
std::int32_t join_strays(const MergeGraph& touching, std::span<const RegionSum> sum, std::int32_t clusters,
                         std::vector<std::int32_t>& cluster);

}  // namespace isimp
