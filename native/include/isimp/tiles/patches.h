#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/metric.h"

namespace isimp::tiles {

/// Small regions of a tile and their graph. The merging of all tiles needs nothing else of a tile.
struct Patches {
  std::vector<std::int32_t> label;                ///< (n) patch of each face, by graph index
  std::vector<RegionSum> sum;                     ///< (K) sum of each patch, scene units squared
  std::vector<std::array<std::int32_t, 2>> pair;  ///< (E) patches that share an edge, the lower one first, rising
  std::vector<double> length;                     ///< (E) length of the shared border, scene units
};

/// Splits a tile into patches of about `size` faces, by the engine's own partition. Each component gets at least the
/// number of patches that its topology needs. No component is left out, because the joined graph decides about that.
///
/// \param size    mean number of faces of a patch, at least 1
/// \param smooth  as PartitionOptions::smooth
/// \throws InvalidInput  size below 1
/// \throws Cancelled     no result
/// Cost: O(F) time; about 130 bytes a face at the peak, with the mesh.
Patches patches(const Mesh& mesh, std::int32_t size, double smooth, Job& job);

}  // namespace isimp::tiles
