#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "isimp/mesh/mesh.h"

namespace isimp::bench {

struct Arrays {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// Reads a mesh file, or makes the mesh of a name `made:KIND:FACES`:
///  - torus    a closed ring with bumps of many sizes and a little noise, like a scan
///  - slivers  the same with triangles hundreds of times longer than wide
///  - plane    a flat square: all faces coplanar
///  - boxes    separate cubes of 12 faces
///  - plate    a plate with rows of square holes, and sheet its upper side alone
///  - sponge   Menger's
///  - soup     triangles without neighbours that pass through each other
/// with about that many faces.
/// \param loop  how often it is subdivided afterwards, each time into four times as many faces
/// \throws InvalidInput  no such file or kind; the file's mesh needs `clean`, if loop > 0
Arrays load_input(const std::string& name, std::int32_t loop);

/// One step of Loop's subdivision, borders as cubic B-splines. The mesh must be sound.
Arrays subdivided(const Arrays& arrays);

}  // namespace isimp::bench
