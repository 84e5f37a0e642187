#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/local.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// A partition being edited: the copy that will be returned, its sums kept up to date.
struct Edit {
  Surface surface;
  const FaceGraph& graph;
  Partition result;
  MeshLabels labels;
  std::vector<std::int32_t> hints;  ///< some face of each region that was touched, in the order of finding

  /// \throws InvalidInput  the partition is not one of this mesh
  Edit(const Mesh& mesh, const Partition& partition);

  /// \throws InvalidInput  not a face of the mesh. \return its graph index
  [[nodiscard]] std::int32_t at(std::int32_t face) const;

  /// Starts over from another partition of the same surface.
  void restart(const Partition& partition);

  /// Moves a face of a region to another one.
  void move(std::int32_t i, std::int32_t to);

  /// Relaxes the borders of these faces and what follows from that. `pinned` does not move.
  void relax(std::span<const std::int32_t> faces, std::int32_t pinned, Job& job);

  /// Gives what these faces, having changed sides, have cut off from its region to those around it. Of a region in
  /// pieces the one that is walked through last stays: the largest, mostly. Cost: of the pieces that are given away.
  void reconnect(std::span<const std::int32_t> changed);

  /// Sum of the regions' errors, as a share of the surface.
  [[nodiscard]] double error() const;

  /// Normals and error from the sums, and a new seed for each region that lost its own or has none yet.
  Partition finish();

 private:
  void reseed(std::int32_t region);
};

}  // namespace isimp
