#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/meshing/polygonize.h"

namespace isimp {

/// The place of a polygon's plane in the atlas: texel coordinates (x, y) lie at origin + x * u + y * v.
/// u and v are as long as a texel, at right angles, and u x v points where n does. n is a unit vector.
struct ChartFrame {
  Vec3 origin, u, v, n;
};

/// Polygons laid out in a square of texels. x points right, y up, (0, 0) is the lower left corner of the image.
struct Atlas {
  std::int32_t side = 0;
  double scale = 0;   ///< texels per scene unit; the same everywhere
  double gutter = 0;  ///< least distance of two charts, texels
  double fill = 0;    ///< area of the polygons over the area of the atlas
  std::int32_t chart_count = 0;
  std::vector<std::array<double, 2>> corner;  ///< (L) the texel coordinates of each corner
  std::vector<std::int32_t> chart;            ///< (Q) the chart of each polygon
  std::vector<ChartFrame> frame;              ///< (Q) in the caller's coordinates
};

/// Lays the polygons out without distortion and without overlap.
///
/// Each polygon is projected on the plane that fits it best, so UVs are affine in it: every triangulation of an n-gon
/// shows the same picture. Neighbours that meet at less than `unfold` degrees are unfolded about their edge into one
/// chart, the longest edges first, where nothing overlaps. Charts fall one after another, in the best of four turns,
/// onto the profile of those below (Levy, Petitjean, Ray, Maillot 2002, section 4). No chart is mirrored.
/// The layout depends on the polygons alone.
///
/// \param side    width and height, texels; 0: the smallest power of two that has `density` texels per scene unit
/// \param gutter  least distance of two charts, texels; 0: side / 512, at least 3 and at most 16
/// \throws InvalidInput  so many charts do not fit into the size; the message says which size they fit
/// \throws Cancelled     nothing was made
/// Cost: 0.1 s for 1,000 polygons.
Atlas unwrap(const PolygonMesh& polygons, std::int32_t side, double density, double unfold, std::int32_t gutter,
             Job& job);

}  // namespace isimp
