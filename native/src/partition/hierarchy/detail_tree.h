#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "components.h"
#include "hierarchy/choose_cut.h"
#include "hierarchy/contraction.h"
#include "hierarchy/dendrogram.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/partition/options.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The input of a detail tree; equal inputs give equal trees.
struct DetailSettings {
  double finest = kFinestDetail;               ///< smallest possible t, as a share of the size
  std::optional<double> noise = std::nullopt;  ///< standard deviation, scene units; none: estimated
  double leave_out = 0.001;                    ///< see PartitionOptions
  bool operator==(const DetailSettings&) const = default;
};

/// The fineness of the tree for t, as a share of the size: kFinestDetail, or halved as often as necessary. It depends
/// on t alone, so that earlier uses of a tree do not show in the result.
double finest_for(double detail);

/// The number of small regions that show a surface without its noise: a twentieth of the faces, within limits.
std::int32_t small_count(std::int32_t faces);

/// The data of a surface that does not depend on its tolerance t: made once, cut at any t from `finest` up.
///
/// Faces (of large surfaces small patches, many at once) merge into patches by filtered normals, since single faces
/// show little but noise; that ends at the finest t. The patches merge to the end by their faces' true normals, so that
/// all remaining detail counts in full.
/// Cost: O(F log F) to make.
class DetailTree {
 public:
  DetailTree(const Surface& surface, const DetailSettings& settings, Job& job, std::int32_t threads = 1);

  /// The cut for t, scene units.
  /// Cost: O(patches log patches).
  [[nodiscard]] Cut choose(double tolerance, bool snap) const;
  /// The number of regions of a cut; relaxing their borders may remove a few.
  /// Cost: O(patches)
  [[nodiscard]] std::int32_t count(const Cut& cut) const { return patches_.count() - merges(cut); }
  /// The regions of a cut, their borders relaxed; regions that then may merge at the same cost are merged.
  /// \param surface  the one the tree was made of
  [[nodiscard]] Regions regions(const Surface& surface, const Cut& cut, const Threads& threads, Job& job) const;

  /// Merges regions of a cut whose borders have moved since, where that costs at most a quarter of the cut.
  /// \param surface  the one the tree was made of
  void merge_again(const Surface& surface, const Cut& cut, Regions& regions, const Threads& threads, Job& job) const;

  /// small_count() regions or a few more or less, their borders not relaxed: (F) by face of the mesh, kNone where a
  /// component is left out.
  /// Cost: O(F).
  [[nodiscard]] std::vector<std::int32_t> small_regions(const Surface& surface) const;

  [[nodiscard]] const DetailSettings& settings() const { return settings_; }
  [[nodiscard]] double size() const { return size_; }    ///< see surface_size()
  [[nodiscard]] double noise() const { return noise_; }  ///< given or estimated, scene units
  [[nodiscard]] const Components& components() const { return components_; }

 private:
  [[nodiscard]] std::int32_t merges(const Cut& cut) const;
  void make_patches(const Surface& surface, std::int32_t thread_count, Job& job);
  void relax_patches(const FaceGraph& graph, Job& job);

  DetailSettings settings_;
  double area_ = 0.0, size_ = 0.0, noise_ = 0.0, bend_ = 0.0;
  Components components_;
  std::vector<std::int32_t> need_;       // least number of regions of each component
  std::vector<std::int32_t> component_;  // component of each patch; empty if there is one
  Regions patches_;                      // their borders relaxed
  std::vector<std::int32_t> small_;      // (F) by graph index: small regions where there are fewer patches; else empty
  std::vector<std::int32_t> borders_;    // faces next to another patch
  MergeTree tree_;                       // over the patches before their borders were relaxed
  MergeGraph touching_;                  // pairs of patches that share an edge since then
  std::vector<double> falling_;          // costs of its dearest merges, scene units squared
};

}  // namespace isimp
