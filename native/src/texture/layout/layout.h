#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/texture/unwrap.h"

namespace isimp::detail {

using Vec2 = Eigen::Vector2d;

/// A turn and a shift of the plane.
struct Rigid {
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
  Vec2 shift = Vec2::Zero();

  Vec2 operator()(const Vec2& p) const { return turn * p + shift; }
};
inline Rigid operator*(const Rigid& a, const Rigid& b) { return {a.turn * b.turn, a.turn * b.shift + a.shift}; }

/// A polygon's own plane: its points are centre + x * u + y * v.
struct Plane {
  Vec3 centre, u, v, n;
};

/// Polygons in their planes, and which of them share a chart.
struct Layout {
  std::vector<Plane> plane;         ///< (Q)
  std::vector<Vec2> flat;           ///< (L) corners in their polygon's plane, scene units
  std::vector<Rigid> place;         ///< (Q) from the polygon's plane into its chart
  std::vector<std::int32_t> chart;  ///< (Q)
  std::vector<std::int32_t> start;  ///< (Q + 1) first corner of each polygon
  std::vector<std::int32_t> group;  ///< (Q) polygons of different groups share neither chart nor tile
  std::int32_t chart_count = 0;
  std::int32_t groups = 1;
  double area = 0;       ///< area of all polygons, scene units squared
  double tile_area = 0;  ///< area of the polygons of the fullest tile, if all tiles of a group are equally full

  [[nodiscard]] std::int32_t polygon_count() const { return static_cast<std::int32_t>(plane.size()); }
  [[nodiscard]] std::int32_t corner_count(std::int32_t q) const { return start[q + 1] - start[q]; }
  /// A corner in its chart.
  [[nodiscard]] Vec2 corner(std::int32_t q, std::int32_t i) const { return place[q](flat[i]); }
};

/// Each polygon in its plane, a chart each. Sets `group`, `groups` and `tile_area` by the options.
Layout flatten(const PolygonMesh& polygons, const AtlasOptions& options);

/// Joins the charts of neighbours that meet at less than `angle` degrees, where nothing overlaps.
void unfold(const PolygonMesh& polygons, double angle, Layout& layout, Job& job);

/// Turns each chart so that its bounding box is smallest, and puts the box's corner at (0, 0).
void straighten(Layout& layout);

/// The places of the charts of a layout: texel = turn * (scale * p) + shift for points p of the chart.
struct Packing {
  double scale = 0;
  std::vector<Rigid> place;        ///< (charts)
  std::vector<std::int32_t> tile;  ///< (charts)
};

/// The room for charts: tiles of `side` texels, for each group as many. Each chart stays at least `grow` texels from
/// its part's border.
struct Room {
  std::int32_t side, tiles;
  double grow;
};

/// The largest scale at which all charts fit into the room, and their places. Empty if they do not fit at any scale.
std::optional<Packing> pack(const Layout& layout, const Room& room, Job& job);

}  // namespace isimp::detail
