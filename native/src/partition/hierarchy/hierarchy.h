#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "components.h"
#include "hierarchy/contraction.h"
#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// A mesh as small smooth patches, and coarser and coarser graphs of them: made once, cut at any number of regions.
///
/// Patches: the faces in Morton order are cut into bundles of 64; a patch is a set of at most `patch_size` faces,
/// connected within a bundle without crossing a crease. Levels: the graph of patches, merged round by round (see
/// merge_round). The cut uses the coarsest level that still has several nodes a region, so that the last merges are
/// made one at a time from exact prices.
struct Hierarchy {
  std::int32_t patch_size = 0;                     ///< faces of a patch at the most
  std::vector<std::int32_t> patch;                 ///< (F) by graph index
  std::vector<std::int32_t> patch_first;           ///< (K + 1) first face of each patch in patch_face
  std::vector<std::int32_t> patch_face;            ///< (F) graph indices, patch by patch
  std::vector<RegionSum> patch_sum;                ///< (K) sums of the faces of each
  std::vector<MergeGraph> level;                   ///< [0] is the graph of patches
  std::vector<std::vector<std::int32_t>> to_next;  ///< [l] node of level l -> node of level l + 1
  std::vector<Component> components;               ///< (C) the components; each cut decides which are kept

  [[nodiscard]] std::int32_t patches() const { return level.empty() ? 0 : level.front().size(); }
  /// Graph indices of the faces of a patch.
  [[nodiscard]] std::span<const std::int32_t> faces_of(std::int32_t p) const {
    return std::span(patch_face).subspan(patch_first[p], static_cast<std::size_t>(patch_first[p + 1] - patch_first[p]));
  }
  /// Whether build_hierarchy would make this very hierarchy for this number of regions.
  [[nodiscard]] bool serves(const Surface& surface, std::int32_t proxies) const;
};

struct HierarchyOptions {
  std::int32_t threads = 1;  ///< 0: as many as there are cores
  /// Nodes of a level from which no coarser one is made: 0 for a hierarchy that is kept for any smaller number of
  /// regions, nodes_for(proxies) for one that is not.
  std::int64_t coarsest = 0;
  /// (n + 1) Records in place of the records of the surface's graph, such as filtered ones; empty: the graph's own.
  std::span<const FaceRecord> faces = {};
  double most = std::numeric_limits<double>::infinity();  ///< no merge of a level adds more to the error
};

/// Makes the hierarchy for `proxies` regions: the patches shrink if there are few faces a region. All counts of up to F
/// / 240 use the same one. It is the same on any number of threads.
/// Cost: O(F), about 45 ms for a million faces.
/// Source: the merging follows reciprocal nearest neighbours, Murtagh 1983, with the error of L2,1.
Hierarchy build_hierarchy(const Surface& surface, std::int32_t proxies, Job& job, const HierarchyOptions& options = {});

/// The least number of nodes of a level from which `regions` regions are merged one pair at a time.
inline std::int64_t nodes_for(std::int32_t regions) { return (std::int64_t{12} * regions + 4) / 5; }

}  // namespace isimp
