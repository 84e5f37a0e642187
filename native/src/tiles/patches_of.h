#pragma once

#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/tiles/patches.h"

namespace isimp::tiles {

/// The patches of a tile and the graph of them.
/// \param label  (n) patch of each face, by graph index; kNone for none
/// \param sum    areas as shares of the tile's
Patches patches_of(const Mesh& mesh, std::vector<std::int32_t> label, std::vector<RegionSum> sum);

}  // namespace isimp::tiles
