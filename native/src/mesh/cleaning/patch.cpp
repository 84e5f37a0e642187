// Fills a loop of edges with triangles.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <iterator>

#include "cleaning/close.h"

namespace isimp::detail {
namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;

std::vector<Point> points(const std::vector<Vec3>& all) {
  std::vector<Point> result;
  result.reserve(all.size());
  for (const Vec3& p : all) result.emplace_back(p.x(), p.y(), p.z());
  return result;
}

Patch without_new_vertices(const std::vector<Vec3>& loop, const std::vector<Vec3>& beyond) {
  Patch patch;
  if (loop.size() == 3) {
    patch.triangles.push_back({0, 1, 2});
    return patch;
  }
  if (loop.front() == loop.back()) return patch;  // CGAL would take the last vertex for the first one repeated
  std::vector<CGAL::Triple<int, int, int>> found;
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(points(loop), points(beyond), std::back_inserter(found));
  if (found.size() + 2 == loop.size())
    for (const auto& t : found) patch.triangles.push_back({t.first, t.second, t.third});
  return patch;
}

Patch round_the_middle(const std::vector<Vec3>& loop) {
  Patch patch;
  if (loop.size() == 3) return patch;  // plan 0 is the better one
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : loop) sum += p;
  patch.inner.emplace_back(sum / static_cast<double>(loop.size()));
  const auto n = static_cast<std::int32_t>(loop.size());
  for (std::int32_t i = 0; i < n; ++i) patch.triangles.push_back({i, (i + 1) % n, n});
  return patch;
}

}  // namespace

Patch cover(const std::vector<Vec3>& loop, const std::vector<Vec3>& beyond, int plan) {
  return plan == 0 ? without_new_vertices(loop, beyond) : round_the_middle(loop);
}

}  // namespace isimp::detail
