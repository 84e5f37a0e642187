#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hierarchy/contraction.h"
#include "isimp/core/job.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// Merges neighbours one pair at a time, cheapest first, until `target` clusters are left. The price is that of
/// merge_round less the price of the border between the two.
///
/// Cost: O(N log N), also where a cluster has most of the others around it, such as the ground of a city.
/// \param sums   (N) exact sums of the nodes; a node without faces is not merged and gets kNone
/// \param need   (C) least number of clusters of each component; its length is 1 if there is one component
/// \return (N) cluster of each node, numbered by first node; more than `target` where components or needs forbid it
std::vector<std::int32_t> merge_greedily(const MergeGraph& graph, std::span<const RegionSum> sums,
                                         std::span<const std::int32_t> need, std::int32_t target, Job& job);

}  // namespace isimp
