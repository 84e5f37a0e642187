#include "isimp/texture/closest_places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "isimp/core/errors.h"
#include "isimp/core/threads.h"
#include "place.h"

namespace isimp {
namespace {

void check(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons,
           std::span<const std::uint8_t> known, std::span<const std::int32_t> group) {
  const auto faces = static_cast<std::size_t>(mesh.face_count());
  if (partition.face_region.size() != faces || (!known.empty() && known.size() != faces) ||
      (!group.empty() && group.size() != faces))
    throw InvalidInput("the partition is not of this mesh, which has " + std::to_string(faces) + " faces");
  for (const std::int32_t r : polygons.polygon_region)
    if (r < 0 || r >= partition.region_count())
      throw InvalidInput("a polygon is of region " + std::to_string(r) + ", but there are " +
                         std::to_string(partition.region_count()));
}

/// Keeps the faces of the group that has most of their area; among equal ones the lowest group.
void keep_largest_group(const Mesh& mesh, std::span<const std::int32_t> group, std::vector<std::int32_t>& faces) {
  std::map<std::int32_t, double> area;
  const auto v = mesh.vertices();
  for (const std::int32_t f : faces) {
    const Triangle& t = mesh.triangles()[f];
    area[group[f]] += (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm();
  }
  if (area.size() < 2) return;
  const auto less = [](const auto& a, const auto& b) { return a.second < b.second; };
  const std::int32_t chosen = std::max_element(area.begin(), area.end(), less)->first;
  std::erase_if(faces, [&](std::int32_t f) { return group[f] != chosen; });
}

}  // namespace

CornerPlaces closest_places(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons,
                            std::span<const std::uint8_t> known, std::span<const std::int32_t> group,
                            std::int32_t threads, Job& job) {
  check(mesh, partition, polygons, known, group);
  std::vector<std::vector<std::int32_t>> inside(partition.region_count());
  std::vector<std::int32_t> all;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (!known.empty() && known[f] == 0) continue;
    all.push_back(f);
    if (const std::int32_t r = partition.face_region[f]; r >= 0) inside[r].push_back(f);
  }
  for (auto& faces : inside)
    if (!group.empty()) keep_largest_group(mesh, group, faces);
  const std::size_t corners = polygons.loops.size();
  CornerPlaces places{std::vector<std::int32_t>(corners, kNone), std::vector<float>(2 * corners, 0)};
  const auto v = mesh.vertices();
  const Threads workers(threads);
  workers.share(polygons.polygon_count(), [&](const auto& next) {
    for (std::int32_t q = next(); q < polygons.polygon_count(); q = next()) {
      const auto& own = inside[polygons.polygon_region[q]];
      const auto& faces = own.empty() ? all : own;
      for (std::int32_t i = polygons.loop_start[q]; i < polygons.loop_end(q); ++i) {
        job.poll();
        const Vec3 p = polygons.vertices[polygons.loops[i]] - mesh.origin();
        detail::Place best;
        for (const std::int32_t f : faces) {
          const Triangle& t = mesh.triangles()[f];
          const detail::Place place = detail::closest_on(p, v[t[0]], v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
          if (!(place.squared < best.squared)) continue;
          best = place;
          places.face[i] = f;
        }
        places.barycentric[2 * static_cast<std::size_t>(i)] = static_cast<float>(best.b);
        places.barycentric[2 * static_cast<std::size_t>(i) + 1] = static_cast<float>(best.c);
      }
    }
  });
  return places;
}

}  // namespace isimp
