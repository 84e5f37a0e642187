#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "planar/unit.h"

namespace isimp::meshing::planar {

using Edge = std::array<std::int32_t, 2>;  ///< corners, the lower first

/// What is asked of triangles, so that the judge will have nothing against them.
struct Rules {
  Vec3 facing = Vec3::UnitZ();  ///< of the piece, for triangles of which the scan tells no direction
  double thickness = 0;         ///< scene units: a thinner one has no area
};

/// Cuts off the corners of a unit that are not on its plane, by as few triangles as will do; what is left stays one
/// polygon, or a few.
/// \param kept  by place in the loop: whether the corner is on the plane; none is, for a unit that is free
/// \param edges  of all polygons: a cut must not join two corners that an edge joins already; new ones are added
/// \param cuts  the edges across the polygon are added here, by corners
/// \return whether there is a way
/// Cost: O(n^3) for n corners.
bool cut(const Unit& unit, const std::vector<std::uint8_t>& kept, const std::vector<Vec3>& at, const Rules& rules,
         std::set<Edge>& edges, std::vector<Edge>& cuts);

}  // namespace isimp::meshing::planar
