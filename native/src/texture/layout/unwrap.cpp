#include "isimp/texture/unwrap.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/to_integer.h"
#include "layout/layout.h"

namespace isimp {
namespace {

using detail::Layout;
using detail::Packing;
using detail::Room;
using detail::Vec2;

constexpr std::int32_t kLeastSide = 16, kMostSide = 8192, kMostChosen = 16384, kMostTiles = 100;  // limit
// tuned texture
constexpr double kUsualFill = 0.55;  // share of an image that charts fill, before it is known

double gutter_of(std::int32_t side, std::int32_t gutter) { return gutter > 0 ? gutter : std::clamp(side / 512, 3, 16); }

/// The margin of a chart. A texel that a polygon touches has its centre within 0.71 of it, and all these centres must
/// lie in the chart's own part.
double grow_of(std::int32_t side, std::int32_t gutter) { return std::max(gutter_of(side, gutter) / 2, 1.25); }

std::int32_t side_for(double area, double density) {
  const double texels = area * density * density / kUsualFill;
  std::int32_t side = kLeastSide;
  while (side < kMostSide && double{1.0} * side * side < texels) side *= 2;
  return side;
}

/// The options with the number of tiles, where none is given: as many of the largest side as the density needs.
AtlasOptions with_tiles(const PolygonMesh& polygons, AtlasOptions options) {
  if (options.tiles > 0) return options;
  const Layout layout = detail::flatten(polygons, options);
  const double texels = layout.tile_area * options.density * options.density / kUsualFill;
  const double tiles = options.side > 0 ? 1 : std::ceil(texels / (double{1.0} * kMostSide * kMostSide));
  const std::int32_t most = std::max(1, kMostTiles / layout.groups);
  options.tiles = to_integer(tiles, 1, most);
  return options;
}

/// Puts a polygon of a packed layout into an atlas.
void put(const Layout& layout, const Packing& packing, std::int32_t q, Atlas& atlas) {
  const detail::Rigid& chart = packing.place[layout.chart[q]];
  const detail::Plane& plane = layout.plane[q];
  const auto texel = [&](const Vec2& p) -> Vec2 {
    return chart.turn * (packing.scale * layout.place[q](p)) + chart.shift;
  };
  for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i) {
    const Vec2 at = texel(layout.flat[i]);
    ISIMP_ASSERT(at.minCoeff() >= 0 && at.x() <= atlas.side && at.y() <= atlas.height(), "corners are in the atlas");
    atlas.corner[i] = {at.x(), at.y()};
  }
  const Eigen::Matrix2d back = (chart.turn * layout.place[q].turn).transpose() / packing.scale;
  const Vec2 zero = texel(Vec2::Zero());
  ChartFrame& frame = atlas.frame[q];
  frame.u = plane.u * back(0, 0) + plane.v * back(1, 0);
  frame.v = plane.u * back(0, 1) + plane.v * back(1, 1);
  frame.n = plane.n;
  frame.origin = plane.centre - frame.u * zero.x() - frame.v * zero.y();
  atlas.tile[q] = packing.tile[layout.chart[q]];
}

Atlas atlas_of(const Layout& layout, const Packing& packing, const Room& room) {
  Atlas atlas;
  atlas.side = room.side;
  atlas.tiles = room.tiles * layout.groups;
  atlas.scale = packing.scale;
  atlas.gutter = 2 * room.grow;
  atlas.fill = layout.area * packing.scale * packing.scale / (static_cast<double>(room.side) * atlas.height());
  atlas.corner.resize(layout.flat.size());
  atlas.tile.resize(layout.plane.size());
  atlas.frame.resize(layout.plane.size());
  for (std::int32_t t = 0; t < atlas.tiles; ++t) atlas.tile_group.push_back(t / room.tiles);
  for (std::int32_t q = 0; q < layout.polygon_count(); ++q) put(layout, packing, q, atlas);
  atlas.chart = layout.chart;
  atlas.chart_count = layout.chart_count;
  return atlas;
}

Layout charts_of(const PolygonMesh& polygons, const AtlasOptions& options, Job& job) {
  Layout layout = detail::flatten(polygons, options);
  if (options.unfold > 0) detail::unfold(polygons, options.unfold, layout, job);
  detail::straighten(layout);
  return layout;
}

}  // namespace

Atlas unwrap(const PolygonMesh& polygons, const AtlasOptions& asked, Job& job) {
  if (polygons.polygon_count() == 0) throw InvalidInput("there are no polygons to lay out");
  const AtlasOptions options = with_tiles(polygons, asked);
  const Layout layout = charts_of(polygons, options, job);
  const auto room_of = [&](std::int32_t side) { return Room{side, options.tiles, grow_of(side, options.gutter)}; };
  const bool chosen = options.side > 0;
  std::int32_t side = chosen ? options.side : side_for(layout.tile_area, options.density);
  for (;; side *= 2) {
    if (const auto packing = detail::pack(layout, room_of(side), job)) return atlas_of(layout, *packing, room_of(side));
    if (chosen || side >= kMostSide) break;
  }
  std::int32_t fits = side;
  while (fits <= kMostChosen && !detail::pack(layout, room_of(fits), job)) fits *= 2;
  throw InvalidInput(std::to_string(layout.chart_count) + " charts do not fit into an image of " +
                     std::to_string(side) + " x " + std::to_string(side) + " pixels" +
                     (fits <= kMostChosen ? "; choose a size of at least " + std::to_string(fits) : ""));
}

}  // namespace isimp
