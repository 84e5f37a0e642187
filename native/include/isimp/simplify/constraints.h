#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"
#include "isimp/simplify/edges.h"

namespace isimp {

/// Constraints of a partition, in addition to its options.
struct Constraints {
  Guides guides = {};                 ///< weights of the faces, and barriers: edges that no region crosses
  std::vector<VertexPair> cuts = {};  ///< (K) barriers that also split a region that they end in
  std::optional<std::vector<std::int32_t>> faces = std::nullopt;  ///< only these get new regions; the others keep the
                                                                  ///< regions of `before`, or get none
  const Partition* before = nullptr;  ///< its locked regions stay to the face, also without `faces`; null: none

  /// The guides with the cuts as barriers.
  [[nodiscard]] Guides with_cuts() const;
};

/// The faces that may get new regions, rising: `faces` or, without them, all that are not left out; in both cases
/// without the faces of locked regions. nullopt: there are neither `faces` nor locked regions.
///
/// \param proxies, leave_out  as in PartitionOptions; proxies is 1 where the number of regions is not known
/// \throws InvalidInput  a face out of range (named); no face; all of them are locked; `before` is of another mesh
std::optional<std::vector<std::int32_t>> open_faces(const Mesh& mesh, const Constraints& constraints,
                                                    std::int32_t proxies, double leave_out, Job& job);

/// The number of given edges with the same region on both sides. Pairs that are no edges do not count.
/// \throws InvalidInput  the partition is of another mesh
std::int64_t inside_regions(const Mesh& mesh, const Partition& partition, std::span<const VertexPair> edges, Job& job);

/// Splits the regions that contain the ends of cuts: the border continues from an end half-way between both sides of a
/// cut.
///
/// Regions are split one after another, from the first cut by inner_edges with the same region on both sides. The
/// unbranched path of such cuts through it divides the region's faces: faces nearer to its left and faces nearer to its
/// right, in steps over edges that are no cuts. Ties are left, and the left keeps the number of the region.
///
/// \return (F) labels, new ones from region_count() on; nullopt where no region is split
/// \throws InvalidInput  the partition is of another mesh
/// Cost: O(V + F), and for each split the faces of the region.
/// Source: own.
std::optional<std::vector<std::int32_t>> parted_at(const Mesh& mesh, const Partition& partition,
                                                   std::span<const VertexPair> cuts, Job& job);

}  // namespace isimp
