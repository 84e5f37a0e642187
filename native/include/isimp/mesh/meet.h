// Exact tests of triangles.
#pragma once

#include <array>

#include "isimp/core/types.h"

namespace isimp {

using Corners = std::array<Vec3, 3>;  ///< places of the three vertices of a triangle

/// Whether the corners do not all lie on one line. Exact.
bool has_area(const Corners& triangle);

/// 1 if p lies on the side of the triangle's plane from which its corners are counter-clockwise, -1 on the other side, 0 in
/// the plane. Exact.
int side_of(const Corners& triangle, const Vec3& p);

/// Whether two triangles that have area meet elsewhere than in the vertices and the edge they share. Exact.
/// \param f, g  their vertices: a vertex named by both is shared, one at the same place is not
bool meet_elsewhere(const Triangle& f, const Corners& s, const Triangle& g, const Corners& t);

}  // namespace isimp
