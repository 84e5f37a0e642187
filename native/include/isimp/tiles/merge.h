#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/metric.h"

namespace isimp::tiles {

/// A graph of the patches or the regions of all tiles.
struct JoinedGraph {
  std::vector<RegionSum> sum;                     ///< (K) sum of each node, scene units squared
  std::vector<std::array<std::int32_t, 2>> pair;  ///< (E) neighbours, in any order; lengths of repeated pairs add up
  std::vector<double> length;                     ///< (E) length of the border that each pair shares, scene units
};

/// The connected components of a joined graph, and the number of regions that each needs.
struct JoinedComponents {
  std::vector<std::int32_t> component;  ///< (K) component of each node, numbered by first node; kNone: left out
  std::vector<std::int32_t> need;       ///< (C) least number of regions: 4 if closed, else 1; 0: left out
  std::int32_t left_out = 0;            ///< number of components that are left out
  double area_left_out = 0.0;           ///< their share of the whole area
};

/// Finds components. Small ones are left out as in a partition of one piece: see PartitionOptions::leave_out.
///
/// \param open  (K) 1 for a node on the border of the whole scan; a component without such a node is closed
/// \throws InvalidInput  arrays of unequal lengths, a pair out of range
/// Cost: O((K + E) log K).
JoinedComponents find_components(const JoinedGraph& graph, std::span<const std::uint8_t> open, std::int32_t proxies,
                                 double leave_out);

/// The weight of borders in a merging, the same as for one piece.
struct BorderPrice {
  double smooth = 0.0;       ///< as PartitionOptions::smooth; 0: borders cost nothing
  double error = 0.0;        ///< error of the present regions, as a share of the area
  std::int32_t proxies = 1;  ///< number of regions after the merging
  double area = 0.0;         ///< area of all tiles, scene units squared; 0: area of the graph
};

/// Merges neighbours one pair at a time, cheapest first, by exact prices, until `target` regions are left.
///
/// \return (K) region of each node, numbered by first node; kNone: left out. The number of regions is above `target` if
///         the components need more
/// \throws InvalidInput  as above
/// \throws Cancelled     no result
/// Cost: O(K log K), even if a node has many neighbours; about 270 bytes a node.
std::vector<std::int32_t> merge(const JoinedGraph& graph, const JoinedComponents& components, std::int32_t target,
                                const BorderPrice& price, Job& job);

/// Merges inside a group of tiles, in order. The second node of a pair becomes part of the first and merges no more.
struct GroupMerges {
  std::vector<std::array<std::int32_t, 2>> merged;  ///< (M) nodes of each merge
  std::vector<double> price;                        ///< (M) half of the increase in error, less the price of the border
};

/// Merges the part of the joined graph that belongs to a group of tiles, as far as that is safe. Nodes with neighbours
/// in other groups do not merge with each other. The price of a merge with one of them is computed as if that node were
/// infinitely large. Afterwards all groups are cut at the same price.
///
/// \param components  components of the group's own graph, with the needs of whole components
/// \param border      (K) 1 for a node with neighbours outside this graph
/// \param target      the number of nodes at which merging ends
/// \param limit       merging ends before a price above it, scene units squared
/// \throws InvalidInput  as above
/// \throws Cancelled     no result
/// Cost: as merge.
GroupMerges merge_inside(const JoinedGraph& graph, const JoinedComponents& components,
                         std::span<const std::uint8_t> border, std::int32_t target, double limit,
                         const BorderPrice& price, Job& job);

}  // namespace isimp::tiles
