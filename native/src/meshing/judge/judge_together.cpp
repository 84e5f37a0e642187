#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "complex/polygons.h"
#include "isimp/core/errors.h"
#include "isimp/meshing/part.h"
#include "judge/judge.h"
#include "judge/together.h"

namespace isimp {
namespace meshing {

void check_parts(const PolygonMesh& mesh, std::span<const std::int32_t> part) {
  const auto polygons = static_cast<std::size_t>(mesh.polygon_count());
  if (part.size() != polygons || mesh.polygon_region.size() != polygons)
    throw InvalidInput("there must be one part and one region for each of " + std::to_string(polygons) + " polygons");
  const auto corners = static_cast<std::int32_t>(mesh.loops.size());
  if (!std::is_sorted(mesh.loop_start.begin(), mesh.loop_start.end()) ||
      (polygons > 0 && (mesh.loop_start.front() != 0 || mesh.loop_start.back() > corners)))
    throw InvalidInput("the starts of loops must rise from 0 and end within the corners");
  for (const std::int32_t v : mesh.loops)
    if (v < 0 || v >= static_cast<std::int32_t>(mesh.vertices.size()))
      throw InvalidInput("a corner names vertex " + std::to_string(v) + ", but there are " +
                         std::to_string(mesh.vertices.size()));
}

std::vector<Vec3> near_zero(const PolygonMesh& mesh, std::span<const Vec3> places) {
  std::vector<Vec3> result(places.begin(), places.end());
  for (Vec3& p : result) p -= mesh.vertices.front();
  return result;
}

}  // namespace meshing

using namespace meshing;

PolygonMesh judge_together(PolygonMesh mesh, std::span<const std::int32_t> part, const Job& job) {
  check_parts(mesh, part);
  mesh.report = {};
  mesh.report.polygons = mesh.polygon_count();
  mesh.report.corners = static_cast<std::int32_t>(mesh.loops.size());
  mesh.report.vertices = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.planarity.clear();
  const std::vector<Vec3> position = near_zero(mesh, mesh.vertices);
  std::vector<FacetSet> sets(mesh.loop_start.size());
  Arounds arounds;
  double area = 0, bent = 0;
  for (std::int32_t q = 0; q < mesh.polygon_count(); ++q) {
    job.poll();
    const auto loop = loop_of(mesh, q);
    const Vec3 across = vector_area(loop, position);
    const PolygonVerdict verdict =
        judge_polygon(loop, position, across.normalized(), {}, Facet{{}, q, 0}, &sets[q].facets);
    if ((verdict.faults & kCrossing) != 0) {
      ++mesh.report.crossing;
      mesh.report.imperfect.push_back({q, Flaw::crossing});
    }
    sets[q].locate(position);
    arounds.set(q, sets[q]);
    mesh.planarity.push_back(bend_of(loop, position));
    area += across.norm();
    bent += across.norm() * mesh.planarity.back();
    mesh.report.planarity_max = std::max(mesh.report.planarity_max, mesh.planarity.back());
  }
  mesh.report.planarity_mean = area > 0 ? bent / area : 0.0;
  arounds.settle();
  std::vector<const FacetSet*> by_polygon;
  by_polygon.reserve(sets.size());
  for (const FacetSet& set : sets) by_polygon.push_back(&set);
  const std::vector<bool> all(sets.size(), true), none(sets.size(), false);
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (const Hit& hit : find_hits(by_polygon, arounds, position, all, none, Threads(1), job))
    if (part[hit.a] != part[hit.b]) pairs.emplace_back(hit.a, hit.b);
  mesh.report.intersecting = static_cast<std::int64_t>(pairs.size());
  for (const auto& [a, b] : pairs) {
    mesh.report.imperfect.push_back({a, Flaw::intersecting, b});
    mesh.report.imperfect.push_back({b, Flaw::intersecting, a});
  }
  std::sort(mesh.report.imperfect.begin(), mesh.report.imperfect.end());
  if (mesh.source_vertex.size() != mesh.vertices.size()) {
    mesh.source_vertex.resize(mesh.vertices.size());
    std::iota(mesh.source_vertex.begin(), mesh.source_vertex.end(), 0);
  }
  judge_topology(mesh);
  return mesh;
}

}  // namespace isimp
