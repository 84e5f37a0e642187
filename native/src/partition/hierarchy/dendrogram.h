#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/regions.h"

namespace isimp {

/// A graph of the clusters that may merge, faces or regions.
struct ClusterGraph {
  std::vector<RegionSum> sum;           ///< (N)
  std::vector<std::int32_t> first;      ///< (N + 1) neighbours of u: neighbour[first[u]] ... before first[u + 1]
  std::vector<std::int32_t> neighbour;  ///< each pair is there twice, once at either end; repeats are allowed
  std::vector<std::int32_t> component;  ///< (N) the component of each; empty if that does not matter
};

/// A cluster for each face.
/// \param faces  (n + 1) in place of graph.faces
ClusterGraph face_clusters(const FaceGraph& graph, std::span<const FaceRecord> faces);

/// A cluster for each region.
ClusterGraph region_clusters(const FaceGraph& graph, const Regions& regions, Job& job);

/// The merges in order. Node k < leaves is cluster k of the graph, node leaves + k is the result of merge k.
struct MergeTree {
  std::int32_t leaves = 0;
  std::vector<std::array<std::int32_t, 2>> merged;  ///< (M)
  std::vector<double> cost;                         ///< (M) the error that each added, as a share of the area

  [[nodiscard]] std::size_t merges() const { return merged.size(); }
};

struct MergeLimits {
  double cost = std::numeric_limits<double>::infinity();  ///< merging ends before the first merge that costs more
  std::span<const std::int32_t> need;  ///< (components) the least number of clusters to leave of each; empty: 1
  /// Called before each merge of two nodes; if it returns true, the new node is leaves + merges made before. Empty:
  /// always.
  std::function<bool(std::int32_t, std::int32_t)> accept = {};
};

/// Merges the pair of neighbours whose merge raises the error least, again and again.
///
/// Where faces lie in one plane all costs are rounding; small clusters are then merged first, so that one cluster does
/// not absorb such a plane face by face. Ties prefer the lower node.
/// \param graph  moved in where it is large: its memory is reused, or freed before merging begins
/// Cost: O(N log N) where clusters have few neighbours; up to 340 bytes a cluster.
MergeTree merge_all(ClusterGraph graph, const MergeLimits& limits, Job& job);

/// The cluster of each leaf after the first `merges` merges, numbered by first leaf.
/// \return (leaves)
std::vector<std::int32_t> cut_after(const MergeTree& tree, std::size_t merges);

}  // namespace isimp
