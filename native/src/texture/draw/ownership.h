#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/texture/unwrap.h"

namespace isimp::detail {

/// The polygon of a texel. An owner is the number of a polygon that contains its centre, or -2 - the number of one
/// whose edge is near (gutter), or kNone.
inline std::int32_t polygon_of(std::int32_t owner) { return owner >= 0 ? owner : -2 - owner; }

/// The corners of a polygon in texels.
std::span<const std::array<double, 2>> outline_of(const PolygonMesh& polygons, const Atlas& atlas, std::int32_t q);

/// (side * height) the owner of each texel, row by row from the bottom. If two polygons of a chart claim the centre of
/// a texel, it belongs to the first of them.
Array<std::int32_t> find_owners(const PolygonMesh& polygons, const Atlas& atlas, const Threads& threads, Job& job);

/// A box of texels: [x0, x1) by [y0, y1).
struct TexelBox {
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] std::int32_t width() const { return x1 - x0; }
  [[nodiscard]] std::int32_t height() const { return y1 - y0; }
};

/// The texels that a polygon can own.
TexelBox box_of_outline(std::span<const std::array<double, 2>> outline, double gutter, std::int32_t side,
                        std::int32_t height);

inline TexelBox box_of_outline(const PolygonMesh& polygons, const Atlas& atlas, std::int32_t q) {
  return box_of_outline(outline_of(polygons, atlas, q), atlas.gutter, atlas.side, atlas.height());
}

/// Lowers `distance`, (width * height) of a box, to the distance of each texel's centre from the outline where that is
/// below `reach`. Other texels do not change.
void measure_edges(std::span<const std::array<double, 2>> outline, const TexelBox& box, float reach,
                   std::span<float> distance);

}  // namespace isimp::detail
