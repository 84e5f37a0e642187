#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/moments.h"

namespace isimp::tiles {

/// A mesh without most of what lies inside its regions.
struct Thinned {
  std::vector<Vec3> vertices;  ///< in the caller's coordinates; only those that are used
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> label;      ///< region of each face
  std::vector<SurfaceMoments> moments;  ///< of the faces of the scan that each stands for; centres as the vertices
};

/// Takes out vertices inside regions, one by one into a neighbour. Vertices on borders of regions and of the mesh stay,
/// so that tiles still fit and each region keeps its boundary, and by that its mean normal.
///
/// A vertex goes only where the surface stays a manifold and no face turns over: the sign of each new face's area, seen
/// along the old face's normal, is certain in spite of rounding. Each face looks within 14 degrees of the mean
/// direction of what it stands for: what stands inside a region is kept, as polygons may be cut by it.
/// \param label    (F) region of each face; faces with kNone are dropped
/// \param moments  (F) of the scan's faces that each face stands for; empty: of the faces themselves. Sums over regions
///                 stay the same
/// \throws InvalidInput  arrays of unequal lengths
/// \throws Cancelled     nothing was made
/// Cost: O(F), about 1 us a face; some 45 bytes a face beside the mesh.
Thinned thin(const Mesh& mesh, std::span<const std::int32_t> label, std::span<const SurfaceMoments> moments, Job& job);

}  // namespace isimp::tiles
