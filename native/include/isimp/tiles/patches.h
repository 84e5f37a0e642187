#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/metric.h"

namespace isimp::tiles {

/// Small regions of a tile and the graph of them: all that leaves the tile for the merging of all tiles.
struct Patches {
  std::vector<std::int32_t> label;                ///< (n) patch of each face, by graph index
  std::vector<RegionSum> sum;                     ///< (K) in scene units squared
  std::vector<std::array<std::int32_t, 2>> pair;  ///< (E) patches that share an edge, the lower first, rising
  std::vector<double> length;                     ///< (E) of what they share, scene units
};

/// Splits a tile into patches of about so many faces, by the engine's own partition. Each component gets at least what
/// its topology needs, and none is left out: both are decided on the joined graph.
///
/// \param size    faces of a patch on average, at least 1
/// \param smooth  as PartitionOptions::smooth
/// \throws InvalidInput  size below 1
/// \throws Cancelled     nothing was made
/// Cost: O(F) time; about 130 bytes a face at the peak, with the mesh.
Patches patches(const Mesh& mesh, std::int32_t size, double smooth, Job& job);

}  // namespace isimp::tiles
