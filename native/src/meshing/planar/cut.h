#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "planar/unit.h"

namespace isimp::meshing::planar {

using Edge = std::array<std::int32_t, 2>;  ///< corners, the lower first

/// The edges of all polygons, by corner.
class Edges {
 public:
  explicit Edges(std::int32_t corners) : beyond_(corners) {}
  [[nodiscard]] bool has(const Edge& e) const;
  void add(const Edge& e) { beyond_[e[0]].push_back(e[1]); }
  void remove(const Edge& e);

 private:
  std::vector<std::vector<std::int32_t>> beyond_;  // by the lower corner; an edge of two polygons stands twice
};

/// The conditions on triangles under which the judge finds no defect in them.
struct Rules {
  Vec3 facing = Vec3::UnitZ();  ///< normal of the chart, for triangles without a direction of the scan
  double thickness = 0;         ///< scene units: a thinner one has no area
};

/// Cuts off the corners of a unit that are not on its plane, by as few triangles as possible. The rest stays one
/// polygon, or a few.
/// \param kept  by place in the loop: whether the corner is on the plane; ignored for a free unit
/// \param own  the edges across it of the triangles that the judge saw, used if `unit.own`
/// \param edges  of all polygons: a cut must not join two corners that an edge joins already; new ones are added
/// \param cuts  the edges across the polygon, by corners
/// \return whether there is a way
/// Cost: O(n^3) for n corners.
bool cut(const Unit& unit, const std::vector<std::uint8_t>& kept, std::span<const Edge> own,
         const std::vector<Vec3>& at, const Rules& rules, Edges& edges, std::vector<Edge>& cuts);

}  // namespace isimp::meshing::planar
