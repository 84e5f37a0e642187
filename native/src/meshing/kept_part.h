#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "isimp/meshing/polygonize.h"

namespace isimp::meshing {

/// The faces of which polygons are made, cut off from all others, and their regions.
struct KeptPart {
  Mesh mesh;
  Partition partition;               ///< without the regions that are left out
  std::vector<std::int32_t> region;  ///< the region in the whole partition of each of its regions
  std::vector<std::int32_t> face;    ///< the face in the whole mesh of each of its faces
};

/// Cuts off the faces of which polygons are made.
/// \return nullopt if the whole mesh can be used: polygons are made of all its faces
/// \throws InvalidInput  all regions are left out
/// Cost: O(F).
std::optional<KeptPart> kept_part(const Mesh& mesh, const Partition& partition, Job& job);

/// Renumbers the regions and vertices of polygons of a part as in the whole.
void to_whole(PolygonMesh& polygons, const KeptPart& part);

}  // namespace isimp::meshing
