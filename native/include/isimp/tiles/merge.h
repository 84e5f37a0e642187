#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/metric.h"

namespace isimp::tiles {

/// The patches, or the regions, of all tiles as one graph.
struct JoinedGraph {
  std::vector<RegionSum> sum;                     ///< (K) in scene units squared
  std::vector<std::array<std::int32_t, 2>> pair;  ///< (E) neighbours, in any order; repeats add up
  std::vector<double> length;                     ///< (E) of the border that each pair shares, scene units
};

/// The connected components of a joined graph, and how many regions each needs.
struct Components {
  std::vector<std::int32_t> component;  ///< (K) of each node, numbered by first node; kNone where it is left out
  std::vector<std::int32_t> need;       ///< (C) least number of regions: 4 if closed, else 1; 0 where it is left out
  std::int32_t left_out = 0;            ///< how many are left out
  double area_left_out = 0.0;           ///< their share of the whole area
};

/// Finds components, and leaves small ones out as a partition of one piece does: see PartitionOptions::leave_out.
///
/// \param open  (K) 1 where a node is on the border of the whole scan; only here is known what is closed
/// \throws InvalidInput  arrays of unequal lengths, a pair out of range
/// Cost: O((K + E) log K).
Components find_components(const JoinedGraph& graph, std::span<const std::uint8_t> open, std::int32_t proxies,
                           double leave_out);

/// What merging weighs borders by: as the engine does for one piece.
struct BorderPrice {
  double smooth = 0.0;       ///< as PartitionOptions::smooth; 0: borders cost nothing
  double error = 0.0;        ///< of the present regions, as a share of the area
  std::int32_t proxies = 1;  ///< how many regions there will be
  double area = 0.0;         ///< of all tiles, scene units squared; 0: that of the graph
};

/// Merges neighbours one pair at a time, cheapest first, by exact prices, until `target` are left.
///
/// \return (K) region of each node, numbered by first node, kNone where it is left out; more than `target` regions
///         where the components need them
/// \throws InvalidInput  as above
/// \throws Cancelled     nothing was made
/// Cost: O(K log K), also beside a node with many neighbours; some 270 bytes a node.
std::vector<std::int32_t> merge(const JoinedGraph& graph, const Components& components, std::int32_t target,
                                const BorderPrice& price, Job& job);

/// Merges inside a group of tiles, in order: the second node of a pair goes into the first, and is not named again.
struct GroupMerges {
  std::vector<std::array<std::int32_t, 2>> merged;  ///< (M)
  std::vector<double> price;                        ///< (M) half of what the error rose by, less that of the border
};

/// Merges the part of the joined graph that a group of tiles has, as far as that is safe: nodes with neighbours in other
/// groups do not merge with each other, and what merges with one pays as if it were endless. All groups are then cut at
/// the same price.
///
/// \param components  of the group's own graph; needs are those of whole components
/// \param border      (K) 1 where a node has neighbours that are not in this graph
/// \param target      the number of nodes at which merging ends
/// \param limit       merging ends before a price above it, scene units squared
/// \throws InvalidInput  as above
/// \throws Cancelled     nothing was made
/// Cost: as merge.
GroupMerges merge_inside(const JoinedGraph& graph, const Components& components, std::span<const std::uint8_t> border,
                         std::int32_t target, double limit, const BorderPrice& price, Job& job);

}  // namespace isimp::tiles
