#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// The sum of a patch or a cluster of patches, in one 16-byte record.
struct NodeSum {
  float x = 0, y = 0, z = 0;  ///< sum of area * normal
  float length = 0;           ///< length of that sum
};

/// A graph of neighbouring patches, or of clusters of them, in compressed rows.
struct MergeGraph {
  std::vector<NodeSum> sum;             ///< (N)
  std::vector<std::int32_t> first;      ///< (N + 1) first neighbour of each node
  std::vector<std::int32_t> neighbour;  ///< each pair is in both rows, no node is its own neighbour
  std::vector<std::int32_t> component;  ///< (N) component of the mesh each lies in; empty if there is only one
  std::vector<double> border;           ///< as `neighbour`: the price of the border between the two; empty: nothing

  [[nodiscard]] std::int32_t size() const { return static_cast<std::int32_t>(sum.size()); }
  [[nodiscard]] std::int32_t component_of(std::int32_t node) const { return component.empty() ? 0 : component[node]; }
  [[nodiscard]] std::span<const std::int32_t> around(std::int32_t node) const {
    return std::span(neighbour).subspan(first[node], static_cast<std::size_t>(first[node + 1] - first[node]));
  }
};

/// The rules of a round of merges.
struct MergeRules {
  /// Nodes whose cheapest partner is in a pair join that pair: coarser, but twice as quick. Such a round has a wide gate.
  bool satellites = false;
  std::int32_t least = 1;  ///< nodes: components of up to 2 (with satellites 3) times this number do not merge
  /// No merge adds more to the error. A finite one replaces the wide gate.
  double most = std::numeric_limits<double>::infinity();
};

/// One round of reciprocal-nearest-neighbour merging: two nodes that are each other's cheapest partner merge, all such
/// pairs at once.
///
/// The price is |S_u| + |S_v| - |S_u + S_v|, half of the error that merging adds. Only pairs below the .7 quantile of
/// all nodes' best prices merge: without that gate big clusters merge where a graph is coarse already, while small ones
/// queue up before one hub elsewhere. With satellites the gate is 64 times as high: it prevents only merges around
/// corners of the shape, which no later step separates.
/// \param map  (N) is set to the new node of each node
/// \return the contracted graph, of the same size if nothing merged
MergeGraph merge_round(const MergeGraph& graph, const MergeRules& rules, std::vector<std::int32_t>& map,
                       const Threads& threads, Job& job);

/// The graph in which all nodes of a cluster are one.
/// \param map  (N) cluster of each node, each in [0, clusters)
MergeGraph contract(const MergeGraph& graph, const std::vector<std::int32_t>& map, std::int32_t clusters,
                    const Threads& threads, Job& job);

}  // namespace isimp
