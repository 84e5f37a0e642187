#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex.h"
#include "discs.h"
#include "isimp/meshing/polygonize.h"
#include "placement.h"
#include "polygons.h"

namespace isimp::meshing {

/// All that is known while a mesh is turned into polygons, from labels to positions, and how to bring it up to date
/// after a local change.
class State {
 public:
  State(const Mesh& m, const Partition& p, const MeshingOptions& o, Job& job);

  /// Splits a piece in two (and on, until all of it is discs): in halves, or near a place. \return whether it could be
  bool split(std::int32_t piece, const Vec3* place, Job& job);
  /// Brings polygons and positions up to date after splits, new corners, new diagonals or pulls.
  /// \param changed  pieces whose diagonals or pulls changed; the others are known
  /// \return the pieces of which a polygon may have changed its place, in rising order
  std::vector<std::int32_t> update(std::vector<std::int32_t> changed);

  const Mesh& mesh;
  const Partition& partition;
  const MeshingOptions& options;
  const std::int32_t regions;            ///< of the partition
  std::int32_t merged_without_area = 0;  ///< pieces that were given to a neighbour, as they had no area
  Labels labels;
  Cutter cutter;
  std::vector<Plane> planes;  ///< by piece
  Complex complex;
  Diagonals diagonals;  ///< by piece
  Corners corners;
  Polygons polygons;
};

}  // namespace isimp::meshing
