#include "isimp/interact/statistics.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "edit.h"
#include "isimp/core/errors.h"
#include "make_partition.h"

namespace isimp {
namespace {

void keep_unique(std::vector<std::int32_t>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

RegionStatistics measure(const Mesh& mesh, const Partition& partition, const FaceGraph& graph, std::int32_t region,
                         std::span<const std::int32_t> faces) {
  RegionStatistics s;
  s.region = region;
  s.faces = static_cast<std::int32_t>(faces.size());
  s.error = region_error(partition, region) * graph.area;
  s.locked = !partition.region_locked.empty() && partition.region_locked[region] != 0;
  const Vec3 normal = partition.region_normal[region];
  const Vec3 origin = mesh.vertices()[mesh.triangles()[faces.front()][0]];
  // Heights above the plane through one vertex: their mean gives the plane through the centroid.
  double sum = 0.0, squares = 0.0, low = 0.0, high = 0.0;
  for (const std::int32_t f : faces) {
    const Triangle& t = mesh.triangles()[f];
    const Vec3 a = mesh.vertices()[t[0]] - origin, b = mesh.vertices()[t[1]] - origin,
               c = mesh.vertices()[t[2]] - origin;
    const double area = 0.5 * (b - a).cross(c - a).norm();
    const double x = normal.dot(a), y = normal.dot(b), z = normal.dot(c);
    s.area += area;
    sum += area * (x + y + z) / 3;
    squares += area * (x * x + y * y + z * z + x * y + y * z + z * x) / 6;
    low = std::min({low, x, y, z});
    high = std::max({high, x, y, z});
    for (const std::int32_t j : graph.neighbours[graph.graph_face[f]]) {
      if (j == graph.size()) continue;
      const std::int32_t other = partition.face_region[graph.mesh_face[j]];
      if (other != region && other != kNone && (s.neighbours.empty() || s.neighbours.back() != other))
        s.neighbours.push_back(other);
    }
  }
  keep_unique(s.neighbours);
  const double mean = s.area > 0 ? sum / s.area : 0.0;
  s.distance_rms = s.area > 0 ? std::sqrt(std::max(0.0, squares / s.area - mean * mean)) : 0.0;
  s.distance_max = std::max(high - mean, mean - low);
  return s;
}

const FaceGraph& graph_of(const Mesh& mesh, const Partition& partition) {
  check_is_of(mesh, partition);
  return Surface(mesh, partition.guided).graph();
}

}  // namespace

RegionStatistics region_statistics(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job) {
  const FaceGraph& graph = graph_of(mesh, partition);
  if (face < 0 || face >= mesh.face_count())
    throw InvalidInput("face must be in [0, " + std::to_string(mesh.face_count()) + "), got " + std::to_string(face));
  const std::int32_t region = partition.face_region[face];
  if (region == kNone) throw InvalidInput("face " + std::to_string(face) + " lies in a part that was left out");
  std::vector<bool> seen(partition.face_region.size(), false);
  std::vector<std::int32_t> faces{face};
  seen[face] = true;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if ((k & 0xffff) == 0) job.poll();
    for (const std::int32_t j : graph.neighbours[graph.graph_face[faces[k]]]) {
      if (j == graph.size()) continue;
      const std::int32_t f = graph.mesh_face[j];
      if (seen[f] || partition.face_region[f] != region) continue;
      seen[f] = true;
      faces.push_back(f);
    }
  }
  std::sort(faces.begin(), faces.end());  // the same order and so the same bits as in all_statistics
  return measure(mesh, partition, graph, region, faces);
}

std::vector<RegionStatistics> all_statistics(const Mesh& mesh, const Partition& partition, Job& job) {
  const FaceGraph& graph = graph_of(mesh, partition);
  std::vector<std::vector<std::int32_t>> faces(partition.region_sum.size());
  for (std::size_t r = 0; r < faces.size(); ++r)
    faces[r].reserve(static_cast<std::size_t>(partition.region_sum[r].faces));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (partition.face_region[f] != kNone) faces[partition.face_region[f]].push_back(f);
  std::vector<RegionStatistics> all;
  for (std::size_t r = 0; r < faces.size(); ++r) {
    job.poll();
    all.push_back(measure(mesh, partition, graph, static_cast<std::int32_t>(r), faces[r]));
  }
  return all;
}

RegionSides region_sides(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                         std::span<const std::int32_t> region, std::int32_t regions) {
  if (region.size() != triangles.size())
    throw InvalidInput("region must have " + std::to_string(triangles.size()) +
                       " numbers, one for each triangle, got " + std::to_string(region.size()));
  if (regions < 0) throw InvalidInput("regions must be at least 0, got " + std::to_string(regions));
  const auto count = static_cast<std::int64_t>(vertices.size());
  RegionSides sides{std::vector<double>(regions, 0.0), std::vector<Vec3>(regions, Vec3::Zero())};
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::int32_t r = region[i];
    if (r < kNone || r >= regions)
      throw InvalidInput("region of triangle " + std::to_string(i) + " must be in [-1, " + std::to_string(regions) +
                         "), got " + std::to_string(r));
    const Triangle& t = triangles[i];
    for (const std::int32_t v : t)
      if (v < 0 || v >= count)
        throw InvalidInput("triangle " + std::to_string(i) + " has vertex " + std::to_string(v) + ", but there are " +
                           std::to_string(count) + " vertices");
    if (r == kNone) continue;
    const Vec3& a = vertices[t[0]];
    const Vec3 normal = 0.5 * (vertices[t[1]] - a).cross(vertices[t[2]] - a);
    const double area = normal.norm();
    if (!std::isfinite(area)) continue;
    sides.area[r] += area;
    sides.normal[r] += normal;
  }
  return sides;
}

}  // namespace isimp
