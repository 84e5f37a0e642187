#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/moments.h"

namespace isimp::tiles {

/// A mesh without most of the vertices inside its regions.
struct Thinned {
  std::vector<Vec3> vertices;  ///< in the caller's coordinates; all of them are used
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> label;      ///< region of each face
  std::vector<SurfaceMoments> moments;  ///< moments of the scan faces that each represents, in the caller's coordinates
};

/// Removes vertices inside regions: each is collapsed into a neighbour. Vertices on borders of regions and of the mesh
/// stay, so tiles still fit, and each region keeps its boundary and therefore its mean normal.
///
/// A vertex is removed only if the surface stays a manifold and no face turns over: the sign of each new face's area,
/// seen along the old face's normal, is certain in spite of rounding. The normal of each face stays within 14 degrees
/// of the mean direction of the scan faces that it represents. So structures inside a region stay: polygons may be cut
/// by them.
/// \param label    (F) region of each face; faces with kNone are dropped
/// \param moments  (F) moments of the scan faces that each face represents; empty: each face represents itself. Sums
///                 over regions stay the same
/// \throws InvalidInput  arrays of unequal lengths
/// \throws Cancelled     no result
/// Cost: O(F), about 1 us a face; about 45 bytes a face in addition to the mesh.
Thinned thin(const Mesh& mesh, std::span<const std::int32_t> label, std::span<const SurfaceMoments> moments, Job& job);

}  // namespace isimp::tiles
