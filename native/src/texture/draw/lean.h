#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/meshing/polygonize.h"
#include "isimp/texture/unwrap.h"

namespace isimp::detail {

/// A direction that leaves a plane: steps right and up for each step out of it.
using Slope = std::array<float, 2>;

/// (L) The way from each polygon's normal to the mean normal of the polygons at its corner, in the polygon's chart.
/// Weights are the polygons' angles; those at sharp edges do not count. So pictures drawn from both sides of an edge
/// nearly meet there.
std::vector<Slope> corner_slopes(const PolygonMesh& polygons, const Atlas& atlas);

/// The slopes at the corners of one polygon.
inline std::span<const Slope> slopes_of(const PolygonMesh& polygons, std::span<const Slope> slopes, std::int32_t q) {
  return slopes.subspan(polygons.loop_start[q], polygons.loop_end(q) - polygons.loop_start[q]);
}

/// The directions along which a polygon is drawn: along each edge the slopes of its corners, and a mean of them inside,
/// weighted by lengths over squared distances.
class Lean {
 public:
  /// Straight along the polygon's normal.
  Lean() = default;
  /// \param outline  corners in texels, which stay alive
  /// \param slopes   one for each corner
  Lean(std::span<const std::array<double, 2>> outline, std::span<const Slope> slopes);

  [[nodiscard]] bool straight() const { return edges_.empty(); }
  [[nodiscard]] Slope at(float x, float y) const;

 private:
  struct Edge {
    float x, y, ex, ey;  // its beginning, and the vector to its end
    float over, length;  // 1 / its squared length
    Slope from, change;
  };
  std::vector<Edge> edges_;
};

}  // namespace isimp::detail
