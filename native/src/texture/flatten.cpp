// Lays each polygon into its plane.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "layout.h"

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

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Vec2> hull_of(std::vector<Vec2> points) {
  const auto before = [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  const auto add = [&](const Vec2& p, std::size_t least) {
    const auto turns_right = [&] {
      const Vec2 a = hull.back() - hull[hull.size() - 2], b = p - hull.back();
      return a.x() * b.y() - a.y() * b.x() <= 0;
    };
    while (hull.size() > least && turns_right()) hull.pop_back();
    hull.push_back(p);
  };
  for (const Vec2& p : points) add(p, 1);
  const std::size_t lower = hull.size();
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

/// The turn with the smallest bounding box: one edge of the convex hull is level then.
Eigen::Matrix2d best_turn(const std::vector<Vec2>& points) {
  const std::vector<Vec2> hull = hull_of(points);
  Eigen::Matrix2d best = Eigen::Matrix2d::Identity();
  double least = -1;
  for (std::size_t i = 0, h = hull.size() - 1; i < hull.size(); h = i++) {
    const Vec2 e = hull[i] - hull[h];
    if (!(e.norm() > 0)) continue;
    const Vec2 d = e.normalized();
    Eigen::Matrix2d turn;
    turn << d.x(), d.y(), -d.y(), d.x();
    Vec2 low = turn * hull[0], high = low;
    for (const Vec2& p : hull) {
      low = low.cwiseMin(turn * p);
      high = high.cwiseMax(turn * p);
    }
    const double area = (high - low).prod();
    if (least < 0 || area < least * (1 - 1e-9)) {  // the first of nearly equal ones, so that rounding does not choose
      least = area;
      best = turn;
    }
  }
  return best;
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
    Rigid rigid{best_turn(points), Vec2::Zero()};
    Vec2 low = rigid(points[0]);
    for (const Vec2& p : points) low = low.cwiseMin(rigid(p));
    rigid.shift = -low;
    for (const std::int32_t q : polygons) layout.place[q] = rigid * layout.place[q];
  }
}

}  // namespace isimp::detail
