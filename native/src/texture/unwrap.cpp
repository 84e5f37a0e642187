#include "isimp/texture/unwrap.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "isimp/core/errors.h"
#include "layout.h"

namespace isimp {
namespace {

constexpr std::int32_t kLeastSide = 16, kMostSide = 8192, kMostChosen = 16384;
constexpr double kUsualFill = 0.55;

double gutter_of(std::int32_t side, std::int32_t gutter) { return gutter > 0 ? gutter : std::clamp(side / 512, 3, 16); }

/// What a chart keeps free around itself. A texel that a polygon touches has its centre within 0.71 of it, and all
/// these must lie in the chart's own part.
double grow_of(std::int32_t side, std::int32_t gutter) { return std::max(gutter_of(side, gutter) / 2, 1.25); }

std::int32_t side_for(double area, double density) {
  const double texels = area * density * density / kUsualFill;
  std::int32_t side = kLeastSide;
  while (side < kMostSide && double{1.0} * side * side < texels) side *= 2;
  return side;
}

Atlas atlas_of(const detail::Layout& layout, const detail::Packing& packing, std::int32_t side, std::int32_t gutter) {
  Atlas atlas;
  atlas.side = side;
  atlas.scale = packing.scale;
  atlas.gutter = 2 * grow_of(side, gutter);
  atlas.fill = layout.area * packing.scale * packing.scale / (static_cast<double>(side) * side);
  atlas.chart_count = layout.chart_count;
  atlas.chart = layout.chart;
  atlas.corner.resize(layout.flat.size());
  for (std::int32_t q = 0; q < layout.polygon_count(); ++q) {
    const detail::Rigid& chart = packing.place[layout.chart[q]];
    const detail::Plane& plane = layout.plane[q];
    const auto texel = [&](const detail::Vec2& p) -> detail::Vec2 {
      return chart.turn * (packing.scale * layout.place[q](p)) + chart.shift;
    };
    for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i) {
      const detail::Vec2 at = texel(layout.flat[i]);
      atlas.corner[i] = {at.x(), at.y()};
    }
    const Eigen::Matrix2d back = (chart.turn * layout.place[q].turn).transpose() / packing.scale;
    const detail::Vec2 zero = texel(detail::Vec2::Zero());
    ChartFrame frame;
    frame.u = plane.u * back(0, 0) + plane.v * back(1, 0);
    frame.v = plane.u * back(0, 1) + plane.v * back(1, 1);
    frame.n = plane.n;
    frame.origin = plane.centre - frame.u * zero.x() - frame.v * zero.y();
    atlas.frame.push_back(frame);
  }
  return atlas;
}

}  // namespace

Atlas unwrap(const PolygonMesh& polygons, std::int32_t side, double density, double unfold, std::int32_t gutter,
             Job& job) {
  detail::Layout layout = detail::flatten(polygons);
  if (unfold > 0) detail::unfold(polygons, unfold, layout, job);
  detail::straighten(layout);
  const bool chosen = side > 0;
  for (side = chosen ? side : side_for(layout.area, density);; side *= 2) {
    if (const auto packing = detail::pack(layout, side, grow_of(side, gutter), job))
      return atlas_of(layout, *packing, side, gutter);
    if (chosen || side >= kMostSide) break;
  }
  std::int32_t fits = side;
  while (fits <= kMostChosen && !detail::pack(layout, fits, grow_of(fits, gutter), job)) fits *= 2;
  throw InvalidInput(std::to_string(layout.chart_count) + " charts do not fit into an image of " +
                     std::to_string(side) + " x " + std::to_string(side) + " pixels" +
                     (fits <= kMostChosen ? "; choose a size of at least " + std::to_string(fits) : ""));
}

}  // namespace isimp
