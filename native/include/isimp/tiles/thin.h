#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"

namespace isimp::tiles {

/// A mesh with fewer faces.
struct Thinned {
  std::vector<Vec3> vertices;  ///< in the caller's coordinates; all of them are vertices of the mesh
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> face;  ///< (F) face of the result that each face of the mesh has become part of
};

/// Removes vertices until `faces` faces are left: each is collapsed into a neighbour, those first whose planes stay
/// nearest. Vertices on the border of the mesh stay, so tiles still fit.
///
/// A vertex is removed only if the surface stays a manifold and no face turns over against the faces that it represents.
/// More faces are left if the others are far from the planes of the faces that they would replace.
/// \throws Cancelled  no result
/// Cost: O(F log F), about 3 us a face; about 90 bytes a face in addition to the mesh.
Thinned thin(const Mesh& mesh, std::int64_t faces, Job& job);

}  // namespace isimp::tiles
