#pragma once

#include <vector>

#include "grid.h"

namespace isimp::curved {

/// The cells of a patch.
struct Cells {
  Some of_face;                  ///< by PatchFaces: ring * segments + segment
  std::vector<CurvedCell> cell;  ///< by that number; `proxy` is not set
  std::vector<Vec3> normal;      ///< normal of the plane of each cell
  std::vector<double> offset;    ///< the plane is where normal * x is this
};

/// The cell of each face, as Cells::of_face, where the corners of cells are not at vertices yet.
Some cells_of_faces(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch);

/// Cuts a patch into cells, so that four meet in one vertex of the scan: by symmetry their planes meet in one point, and
/// two junctions of three would fall together.
/// Cost: O(faces of the patch).
Cells cut(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch);

}  // namespace isimp::curved
