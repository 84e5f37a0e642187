#pragma once

#include <array>
#include <cstdint>
#include <span>
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

/// Polygons laid out in images of texels, the UDIM tiles. x points right, y up. (0, 0) is the lower left corner of the
/// first tile. The tiles are stacked: tile t has the rows from t * side on.
struct Atlas {
  std::int32_t side = 0;   ///< side of a tile, texels
  std::int32_t tiles = 1;  ///< number of tiles
  double scale = 0;        ///< texels per scene unit; the same everywhere
  double gutter = 0;       ///< least distance of two charts, texels
  double fill = 0;         ///< area of the polygons over the area of the atlas
  std::int32_t chart_count = 0;
  std::vector<std::array<double, 2>> corner;  ///< (L) the texel coordinates of each corner
  std::vector<std::int32_t> chart;            ///< (Q) the chart of each polygon
  std::vector<ChartFrame> frame;              ///< (Q) in the caller's coordinates
  std::vector<std::int32_t> tile;             ///< (Q) the tile of each polygon
  std::vector<std::int32_t> tile_group;       ///< (tiles) the group of the polygons of each tile

  /// The number of rows of texels of all stacked tiles.
  [[nodiscard]] std::int32_t height() const { return side * tiles; }
};

/// How polygons are laid out.
struct AtlasOptions {
  std::int32_t side = 0;    ///< side of a tile; 0: the least power of two that has `density`, at most 8,192
  double density = 1;       ///< texels per scene unit
  double unfold = 40;       ///< degrees
  std::int32_t gutter = 0;  ///< least distance of two charts; 0: side / 512, at least 3 and at most 16
  std::int32_t tiles = 1;   ///< number of tiles of each group; 0: one, or as many as `density` needs if no side is
                            ///< given
  std::span<const std::int32_t>
      group{};  ///< (Q) polygons of different groups share no tile; from 0 on; empty: one group
};

/// Lays the polygons out without distortion and without overlap.
///
/// Each polygon is projected on the plane that fits it best, so UVs are affine in it: every triangulation of an n-gon
/// shows the same picture. Neighbours that meet at less than `unfold` degrees are unfolded about their edge into one
/// chart, the longest edges first, where nothing overlaps. Charts fall one after another, in the best of four turns,
/// onto the profile of the charts below (Levy, Petitjean, Ray, Maillot 2002, section 4). No chart is mirrored. The
/// layout depends on the polygons alone.
///
/// \throws InvalidInput  the charts do not fit into the size; the message names a size that fits
/// \throws Cancelled     nothing was made
/// Cost: 0.1 s for 1,000 polygons.
Atlas unwrap(const PolygonMesh& polygons, const AtlasOptions& options, Job& job);

}  // namespace isimp
