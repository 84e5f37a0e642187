#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "borders/local.h"
#include "edit_labels.h"
#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Weights of borders where a partition is edited: the same as where it was made.
inline BorderWeight border_weight_of(const Partition& partition, const FaceGraph& graph) {
  const double error = graph.area > 0 ? partition.error / graph.area : 0.0;
  return border_weight(error + partition.off_planes, partition.smooth, graph.size(), partition.region_count());
}

/// A partition being edited: the copy that will be returned, its sums kept up to date.
struct Edit {
  Surface surface;
  const FaceGraph& graph;
  Partition result;
  EditLabels labels;                  ///< labels of `result`
  std::vector<std::int32_t> borders;  ///< faces that the last relaxation visited
  std::vector<std::int32_t> hints;    ///< some face of each region that was touched, in the order of finding

  /// \throws InvalidInput  the partition is not one of this mesh
  Edit(const Mesh& mesh, const Partition& partition);
  Edit(const Edit&) = delete;
  Edit& operator=(const Edit&) = delete;

  /// \throws InvalidInput  not a face of the mesh.
  /// \return its graph index
  [[nodiscard]] std::int32_t at(std::int32_t face) const;
  /// The region of a face that is to be edited.
  /// \throws InvalidInput  as `at`; left out; its region is locked
  [[nodiscard]] std::int32_t region_at(std::int32_t face) const;
  [[nodiscard]] bool locked(std::int32_t region) const {
    return !result.region_locked.empty() && result.region_locked[region] != 0;
  }

  /// Removes the region of a face from the labels; see take_out.
  /// \param i  by graph index
  /// \throws InvalidInput  the region is in several pieces, as is possible in partitions of other programs: their sums
  ///                       are of all pieces together
  [[nodiscard]] std::vector<std::int32_t> take_region(std::int32_t i);

  /// Replaces the partition by another one of the same surface.
  void restart(const Partition& partition);

  /// By region: 1 if edits must not change it; empty if there is no such region. Initially the locked regions.
  [[nodiscard]] const std::vector<std::uint8_t>& held() const { return held_; }
  void hold(std::vector<std::uint8_t> regions);
  void hold_all_but(std::span<const std::int32_t> regions);

  /// Moves a face of a region to another one.
  void move(std::int32_t i, std::int32_t to);

  /// Adds a region without faces.
  /// \return its number
  std::int32_t add_region();

  /// Removes a region without faces; the numbers above it decrease by one.
  void remove_region(std::int32_t region);

  /// Relaxes the borders of these faces and all that are affected. `pinned` does not move.
  /// \return every visited face, which include all borders that moved
  std::vector<std::int32_t> relax(std::span<const std::int32_t> faces, std::int32_t pinned, Job& job);

  /// Adds the faces that a change of these faces has cut off from their old region to the regions around. Of a region
  /// in pieces the last one that is walked stays, which is the largest one mostly.
  /// Cost: the size of the pieces that change regions.
  void reconnect(std::span<const std::int32_t> changed);

  /// Sum of the regions' errors, as a share of the surface.
  [[nodiscard]] double error() const;

  /// Normals and error from the sums, and a new seed for each region that lost its own or has none yet.
  Partition finish();

 private:
  void reseed(std::int32_t region);

  /// Releases held planes of regions that the edit has changed.
  void keep_planes();

  std::vector<std::uint8_t> held_;
  std::vector<RegionSum> sums_;  ///< sums before the edit, where planes are held
};

}  // namespace isimp
