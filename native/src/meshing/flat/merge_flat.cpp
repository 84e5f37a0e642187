#include "isimp/meshing/merge_flat.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "flat/flat.h"
#include "isimp/core/errors.h"
#include "judge/judge.h"

namespace isimp {
namespace {

using meshing::flat::Loop;
using meshing::flat::Regions;

/// Loops without the vertices that are no corners.
std::vector<Loop> with_corners(std::vector<Loop> loops, const std::vector<char>& is_corner) {
  for (Loop& loop : loops) std::erase_if(loop, [&](std::int32_t v) { return is_corner[v] == 0; });
  return loops;
}

/// Marks the regions at edges that more than two polygons have, or two in the same direction: slivers that have lost
/// all between their ends.
/// \return whether a region was newly marked
bool mark_doubled(const std::vector<std::vector<Loop>>& polygons, std::vector<char>& as_it_is) {
  std::vector<std::array<std::int32_t, 4>> edges;  // both ends, the direction, the region
  for (std::size_t r = 0; r < polygons.size(); ++r) {
    for (const Loop& loop : polygons[r]) {
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::int32_t a = loop[i], b = loop[i + 1 < loop.size() ? i + 1 : 0];
        edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : 0, static_cast<std::int32_t>(r)});
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  bool found = false;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end][0] == edges[i][0] && edges[end][1] == edges[i][1]) ++end;
    if (end - i > 2 || (end - i == 2 && edges[i][2] == edges[i + 1][2])) {
      for (; i < end; ++i) {
        found = found || as_it_is[edges[i][3]] == 0;
        as_it_is[edges[i][3]] = 1;
      }
    }
    i = end;
  }
  return found;
}

/// The region as its own faces, merged as far as they stay polygons.
std::vector<Loop> own_faces(const Mesh& mesh, std::span<const std::int32_t> faces) {
  std::vector<Loop> made;
  for (const std::int32_t f : faces) {
    const Triangle& t = mesh.triangles()[f];
    made.push_back({t[0], t[1], t[2]});
  }
  return meshing::flat::joined(mesh, std::move(made));
}

/// The polygons of each region. One that can't be cut keeps its vertices, and so do its neighbours along it.
std::vector<std::vector<Loop>> polygons_of(const Mesh& mesh, const Regions& regions, const Job& job) {
  const auto loops = meshing::flat::find_loops(mesh, regions);
  std::vector<std::vector<Loop>> made(regions.count());
  std::vector<char> as_it_is(regions.count(), 0), is_corner;
  for (bool again = true; again;) {
    job.poll();
    again = false;
    meshing::flat::mark_corners(mesh, regions, loops, as_it_is, is_corner);
    for (std::int32_t r = 0; r < regions.count(); ++r) {
      if (r % 1024 == 0) job.poll();
      if (as_it_is[r] == 0) made[r] = meshing::flat::cut(mesh, regions.plane[r], with_corners(loops[r], is_corner));
      if (as_it_is[r] == 0 && made[r].empty()) {
        as_it_is[r] = 1;
        again = true;
      }
      if (as_it_is[r] != 0) made[r] = own_faces(mesh, regions.faces(r));
    }
    again = mark_doubled(made, as_it_is) || again;
  }
  return made;
}

void measure(PolygonMesh& made, const Mesh& mesh, const Regions& regions) {
  MeshingReport& report = made.report;
  report.polygons = made.polygon_count();
  report.corners = static_cast<std::int32_t>(made.loops.size());
  report.vertices = static_cast<std::int32_t>(made.vertices.size());
  report.regions = regions.count();
  double area = 0, sum = 0;
  for (std::int32_t q = 0; q < made.polygon_count(); ++q) {
    const auto& plane = regions.plane[made.polygon_region[q]];
    double most = 0;
    Vec3 normal = Vec3::Zero();
    const Vec3 first = made.vertices[made.loops[made.loop_start[q]]];
    for (std::int32_t i = made.loop_start[q]; i < made.loop_end(q); ++i) {
      const std::int32_t next = i + 1 < made.loop_end(q) ? i + 1 : made.loop_start[q];
      const Vec3 p = mesh.vertices()[made.source_vertex[made.loops[i]]];
      most = std::max(most, std::abs((p - plane.centre).dot(plane.normal)));
      normal += (made.vertices[made.loops[i]] - first).cross(made.vertices[made.loops[next]] - first);
    }
    made.planarity.push_back(most);
    report.planarity_max = std::max(report.planarity_max, most);
    area += normal.norm();
    sum += normal.norm() * most;
  }
  report.planarity_mean = area > 0 ? sum / area : 0;
  meshing::judge_topology(made);
}

}  // namespace

FlatMerge merge_flat(const Mesh& mesh, double angle, std::span<const std::int32_t> group, Job& job) {
  if (!(angle >= 0 && angle <= 90))
    throw InvalidInput("angle must be in [0, 90] degrees, got " + std::to_string(angle));
  if (!group.empty() && group.size() != mesh.triangles().size()) {
    throw InvalidInput("group must have one number for each of the " + std::to_string(mesh.face_count()) +
                       " faces, got " + std::to_string(group.size()));
  }
  const Job::Stage stage(job, "merging", 0.0, 1.0);
  Regions regions = meshing::flat::find_regions(mesh, angle, group, job);
  job.report(0.5);
  const auto polygons = polygons_of(mesh, regions, job);
  PolygonMesh made;
  std::vector<std::int32_t> number(mesh.vertex_count(), 0);
  for (const auto& of_region : polygons) {
    for (const Loop& loop : of_region) {
      for (const std::int32_t v : loop) number[v] = 1;
    }
  }
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (number[v] == 0) continue;
    number[v] = static_cast<std::int32_t>(made.vertices.size());
    made.vertices.push_back(mesh.vertices()[v] + mesh.origin());
    made.source_vertex.push_back(v);
  }
  for (std::int32_t r = 0; r < regions.count(); ++r) {
    const auto parts = static_cast<std::int32_t>(polygons[r].size());
    if (parts > 1) ++made.report.regions_split;
    made.report.split_for_holes += parts - 1;
    for (const Loop& loop : polygons[r]) {
      made.loop_start.push_back(static_cast<std::int32_t>(made.loops.size()));
      made.polygon_region.push_back(r);
      for (const std::int32_t v : loop) made.loops.push_back(number[v]);
    }
  }
  measure(made, mesh, regions);
  return {std::move(made), std::move(regions.label)};
}

}  // namespace isimp
