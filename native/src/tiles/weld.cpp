#include "isimp/tiles/weld.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/sorted.h"
#include "isimp/core/to_integer.h"
#include "isimp/mesh/hash_grid.h"

namespace isimp::tiles {
namespace {

void check_length(double length) {
  if (!(length > 0) || !std::isfinite(length))
    throw InvalidInput("the length to weld within must be above 0, got " + std::to_string(length));
}

/// A point, and the nearest place of an earlier tile that it could take.
struct Wish {
  std::int32_t place;
  double distance;
  std::int32_t point;
  bool operator<(const Wish& o) const {
    return place != o.place ? place < o.place : distance != o.distance ? distance < o.distance : point < o.point;
  }
};

}  // namespace

std::vector<std::int32_t> weld(std::span<const Vec3> points, std::span<const std::int32_t> tile, double length,
                               Job& job) {
  check_length(length);
  if (tile.size() != points.size()) throw InvalidInput("each point must have a tile");
  if (!std::is_sorted(tile.begin(), tile.end())) throw InvalidInput("points must be in the order of their tiles");
  const auto count = static_cast<std::int32_t>(points.size());
  std::vector<std::int32_t> to(points.size());
  detail::HashGrid grid(points.size(), length);
  std::vector<Wish> wishes;
  for (std::int32_t begin = 0, end = 0; begin < count; begin = end) {
    wishes.clear();
    for (; end < count && tile[end] == tile[begin]; ++end) {
      if ((end & 0x3f) == 0) job.poll();  // where the length is large, all points are near
      to[end] = end;
      const detail::HashGrid::Nearest best = grid.nearest(points, points[end]);
      if (best.point != kNone) wishes.push_back({best.point, best.distance, end});
    }
    std::sort(wishes.begin(), wishes.end());
    for (std::size_t k = 0, first = 0; k < wishes.size(); ++k) {
      if (wishes[k].place != wishes[first].place) first = k;
      // Vertices of a tile at exactly the same place move together.
      if (k == first || points[wishes[k].point] == points[wishes[first].point]) to[wishes[k].point] = wishes[k].place;
    }
    for (std::int32_t i = begin; i < end; ++i)
      if (to[i] == i) grid.keep(points[i], i);
  }
  ISIMP_ASSERT(
      std::ranges::all_of(numbers_below(count), [&](std::int32_t i) { return to[i] <= i && to[to[i]] == to[i]; }),
      "points move to kept points of earlier tiles");
  return to;
}

std::vector<OnEdge> points_on_edges(std::span<const Vec3> ends, std::span<const Vec3> points, double length, Job& job) {
  check_length(length);
  if (ends.size() % 2 != 0) throw InvalidInput("each edge must have two ends");
  const auto edges = static_cast<std::int32_t>(ends.size() / 2);
  double mean = 0;
  for (std::int32_t e = 0; e < edges; ++e) mean += (ends[2 * e + 1] - ends[2 * e]).norm() / edges;
  const double step = std::max(mean, 2 * length);
  detail::HashGrid grid(points.size(), step);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(points.size()); ++i) grid.keep(points[i], i);
  std::vector<OnEdge> result;
  std::vector<std::int32_t> found;
  for (std::int32_t e = 0; e < edges; ++e) {
    if ((e & 0xfff) == 0) job.poll();
    const Vec3 &a = ends[2 * e], &b = ends[2 * e + 1];
    const Vec3 d = b - a;
    const double size = d.norm();
    if (!(size > 0)) continue;
    found.clear();
    const std::int32_t steps = to_integer(std::ceil(size / step), 0, edges + 1) + 1;
    for (std::int32_t s = 0; s <= steps; ++s)
      grid.for_each_near(a + static_cast<double>(s) / steps * d, [&](std::int32_t i) { found.push_back(i); });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    const std::size_t first = result.size();
    for (const std::int32_t i : found) {
      const Vec3 p = points[i] - a;
      const double along = p.dot(d) / (size * size);
      if (along <= 0 || along >= 1 || (p - along * d).norm() > length) continue;
      if (p.norm() <= length || (points[i] - b).norm() <= length) continue;
      result.push_back({e, i, along});
    }
    std::sort(result.begin() + static_cast<std::ptrdiff_t>(first), result.end(), [](const OnEdge& x, const OnEdge& y) {
      return x.along != y.along ? x.along < y.along : x.point < y.point;
    });
  }
  return result;
}

}  // namespace isimp::tiles
