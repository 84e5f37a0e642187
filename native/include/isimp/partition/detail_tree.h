#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/count.h"
#include "isimp/partition/merge_tree.h"
#include "isimp/partition/parts.h"
#include "isimp/partition/regions.h"

namespace isimp {

/// The finest step of the detail slider, as a share of the surface's size.
inline constexpr double kFinestDetail = 0.00125;

/// What of a surface stays while its tolerance t is moved: made once, cut at any t from `finest` up.
///
/// Faces merge into patches by filtered normals, since single faces show little but noise; that ends at the finest t.
/// The patches merge to the end by their faces' true normals, so that what detail there is counts in full.
class DetailTree {
 public:
  /// \param graph   mesh.graph(), or one with other areas or fewer neighbours
  /// \param noise   standard deviation, scene units
  /// \param finest  smallest t that will be asked for, scene units
  DetailTree(const Mesh& mesh, const FaceGraph& graph, const Parts& parts, double noise, double finest, Job& job);

  /// Where to cut for t, scene units. Cost: O(patches log patches).
  [[nodiscard]] Cut choose(double tolerance, bool snap) const;
  /// How many regions a cut gives; a few less may be left when their borders have been relaxed. Cost: O(patches)
  [[nodiscard]] std::int32_t count(const Cut& cut) const { return patches_.count() - merges(cut); }
  /// The regions of a cut, their borders relaxed; what then may merge at the same cost has merged.
  /// \param graph  the one the tree was made of
  [[nodiscard]] Regions regions(const FaceGraph& graph, const Cut& cut, Job& job) const;

 private:
  [[nodiscard]] std::int32_t merges(const Cut& cut) const;

  std::vector<std::int32_t> need_;  // least number of regions of each component
  std::vector<std::int32_t> part_;  // component of each patch; empty if there is one
  Regions patches_;
  MergeTree tree_;  // over the patches
  double area_ = 0.0, noise_ = 0.0, bend_ = 0.0;
};

}  // namespace isimp
