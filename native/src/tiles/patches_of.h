#pragma once

#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/tiles/patches.h"

namespace isimp::tiles {

/// Returns the patches of a tile and their graph.
/// \param label  (n) patch of each face, by graph index; kNone: none
/// \param sum    areas as shares of the tile's area
Patches patches_of(const Mesh& mesh, std::vector<std::int32_t> label, std::vector<RegionSum> sum);

}  // namespace isimp::tiles
