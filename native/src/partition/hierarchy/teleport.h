#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "borders/relax.h"
#include "components.h"
#include "hierarchy/contraction.h"
#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/regions.h"

namespace isimp {

/// Moves that leave local minima: a region that is worth little moves to a place where it is worth much.
class Teleport {
 public:
  /// \param component   (R) component of each region; empty if there is one
  /// \param relaxation  over the same regions; its pushed faces must include all border faces
  Teleport(const FaceGraph& graph, const Components& components, Regions& regions, std::vector<std::int32_t> component,
           Relaxation<GraphLabels>& relaxation);

  /// Splits the worst regions until every component has its need and there are components.regions() in all.
  /// \return whether any had to be split
  bool fill_up(Job& job);

  /// Whether `run` could change anything, judged by earlier adjacent pairs of regions: cheap, and it saves the search
  /// of `run` where no region is far above the usual.
  [[nodiscard]] bool worth_trying(const MergeGraph& pairs, double least_ratio) const;

  /// Merges the cheapest neighbouring pair and splits the region with the largest gain, as long as that lowers the
  /// error; then relaxes the borders of both.
  ///
  /// Regions are tried in the order of their error, the most a split can gain.
  /// \param tries  a round ends after this many regions in a row without gain
  /// Regions much worse than the usual are also split again from each of their neighbours.
  /// \param least_ratio  a region is tried only if its error is at least this many times the price of the merge that
  ///                     pays for it
  /// \return number of moves
  /// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.5 (region teleportation).
  int run(int tries, double least_ratio, Job& job);

 private:
  struct Pair {
    double cost;
    std::int32_t u, v;
  };
  [[nodiscard]] std::vector<Pair> cheapest_pairs() const;
  [[nodiscard]] std::vector<std::int32_t> worst_regions() const;
  [[nodiscard]] double renewal_bound(const std::vector<std::int32_t>& worst, double least_ratio) const;
  int round(int tries, double least_ratio, Job& job);
  int renew(int tries, double least_ratio, Job& job);
  bool part_anew(std::int32_t region, std::int32_t other, Job& job);
  bool move(const Pair& pair, std::int32_t region, double price, Job& job);
  double split(std::int32_t region, std::int32_t fresh, Job& job);
  void undo_split(std::int32_t region);
  void accept_split(std::int32_t region, std::int32_t fresh);
  void merge(std::int32_t into, std::int32_t from, Job& job);
  std::int32_t component_of(std::int32_t region) const { return component_.empty() ? 0 : component_[region]; }
  std::int32_t face_of(std::int32_t region, Job& job);
  void push_borders(std::span<const std::int32_t> faces);

  const FaceGraph& graph_;
  const Components& components_;
  Regions& regions_;
  GraphLabels labels_;
  std::vector<std::int32_t> component_, count_;  // component of each region; regions of each component
  Relaxation<GraphLabels>& relaxation_;
  std::vector<std::int32_t> some_face_;  // (R) a former face of each region
  std::vector<std::int32_t> faces_;      // faces of the region that was split last
  RegionSum halves_[2];
  struct Tried {
    double error = -1;  // error of the region when it was tried; it is not tried again while that holds
    double gain = 0;
    double renewed = -1;  // its error when it was split again from all its neighbours in vain
  };
  std::vector<Tried> tried_;
  double parted_gain_ = 0;         // fall of the error at the last repeated split of two regions
  std::int64_t renewal_work_ = 0;  // faces that renew() may still touch
  std::int64_t move_work_ = 0;     // faces of regions that may be split before the last round
};

}  // namespace isimp
