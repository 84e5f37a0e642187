// Lays each polygon into its plane.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "isimp/core/least_box.h"
#include "layout/layout.h"

namespace isimp::detail {
namespace {

/// Twice the vector area of a polygon (Newell), about its first corner.
Vec3 newell(const PolygonMesh& polygons, std::int32_t begin, std::int32_t end) {
  const Vec3& first = polygons.vertices[polygons.loops[begin]];
  Vec3 sum = Vec3::Zero();
  for (std::int32_t i = begin + 1; i + 1 < end; ++i)
    sum += (polygons.vertices[polygons.loops[i]] - first).cross(polygons.vertices[polygons.loops[i + 1]] - first);
  return sum;
}

Plane plane_of(const PolygonMesh& polygons, std::int32_t begin, std::int32_t end) {
  Plane plane{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  if (end == begin) return plane;
  const auto at = [&](std::int32_t i) -> const Vec3& { return polygons.vertices[polygons.loops[i]]; };
  for (std::int32_t i = begin; i < end; ++i) plane.centre += (at(i) - at(begin)) / (end - begin);
  plane.centre += at(begin);
  Vec3 longest = Vec3::Zero();
  for (std::int32_t i = begin, h = end - 1; i < end; h = i++)
    if ((at(i) - at(h)).squaredNorm() > longest.squaredNorm()) longest = at(i) - at(h);
  Vec3 n = newell(polygons, begin, end);
  if (!(n.norm() > 1e-12 * longest.squaredNorm())) {  // no area: any plane through the longest edge will do
    if (!(longest.norm() > 0)) return plane;
    n = longest.unitOrthogonal();
  }
  plane.n = n.normalized();
  const Vec3 along = longest - plane.n * plane.n.dot(longest);
  plane.u = along.norm() > 1e-9 * longest.norm() ? Vec3(along.normalized()) : plane.n.unitOrthogonal();
  plane.v = plane.n.cross(plane.u);
  return plane;
}

}  // namespace

Layout flatten(const PolygonMesh& polygons, const AtlasOptions& options) {
  Layout layout;
  const std::int32_t count = polygons.polygon_count();
  layout.group.assign(options.group.begin(), options.group.end());
  layout.group.resize(count, 0);
  layout.groups = 1 + *std::max_element(layout.group.begin(), layout.group.end());
  std::vector<double> area(layout.groups, 0.0);
  layout.start.assign(polygons.loop_start.begin(), polygons.loop_start.end());
  layout.start.push_back(static_cast<std::int32_t>(polygons.loops.size()));
  layout.flat.resize(polygons.loops.size());
  layout.place.resize(count);
  layout.chart.resize(count);
  std::iota(layout.chart.begin(), layout.chart.end(), 0);
  layout.chart_count = count;
  for (std::int32_t q = 0; q < count; ++q) {
    const std::int32_t begin = layout.start[q], end = layout.start[q + 1];
    const Plane plane = plane_of(polygons, begin, end);
    for (std::int32_t i = begin; i < end; ++i) {
      const Vec3 d = polygons.vertices[polygons.loops[i]] - plane.centre;
      layout.flat[i] = {d.dot(plane.u), d.dot(plane.v)};
    }
    area[layout.group[q]] += newell(polygons, begin, end).norm() / 2;
    layout.plane.push_back(plane);
  }
  layout.area = std::accumulate(area.begin(), area.end(), 0.0);
  layout.tile_area = *std::max_element(area.begin(), area.end()) / std::max(1, options.tiles);
  return layout;
}

void straighten(Layout& layout) {
  std::vector<std::vector<std::int32_t>> members(layout.chart_count);
  for (std::int32_t q = 0; q < layout.polygon_count(); ++q) members[layout.chart[q]].push_back(q);
  std::vector<Vec2> points;
  for (const auto& polygons : members) {
    points.clear();
    for (const std::int32_t q : polygons)
      for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i) points.push_back(layout.corner(q, i));
    if (points.empty()) continue;
    Rigid rigid{least_box_turn(points), Vec2::Zero()};
    Vec2 low = rigid(points[0]);
    for (const Vec2& p : points) low = low.cwiseMin(rigid(p));
    rigid.shift = -low;
    for (const std::int32_t q : polygons) layout.place[q] = rigid * layout.place[q];
  }
}

}  // namespace isimp::detail
