#include "isimp/partition/partition.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "components.h"
#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/threads.h"
#include "isimp/partition/regions.h"
#include "make_partition.h"
#include "parts.h"

namespace isimp {

Partition make_partition(const Surface& surface, const Components& components, const Regions& regions,
                         std::vector<double> history, const Threads& threads, Job& job) {
  const FaceGraph& graph = surface.graph();
  Partition result;
  result.face_region.resize(static_cast<std::size_t>(graph.size()));
  threads.run(graph.size(), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i) {
      if ((i & 0xffff) == 0) job.poll();
      result.face_region[graph.mesh_face[i]] = regions.label[i];
    }
  });
  result.region_seed = nearest_faces(graph, regions, job, threads);
  ISIMP_ASSERT(std::find(result.region_seed.begin(), result.region_seed.end(), kNone) == result.region_seed.end(),
               "no region is empty");
  for (std::int32_t& seed : result.region_seed) seed = graph.mesh_face[seed];
  result.region_normal.reserve(regions.sum.size());
  for (const RegionSum& s : regions.sum) result.region_normal.push_back(s.normal());

  result.region_sum = regions.sum;
  result.off_planes = regions.off_planes;
  result.error = regions.error() * graph.area;
  result.history = std::move(history);
  for (double& error : result.history) error *= graph.area;
  result.proxies_asked = components.asked;
  result.proxies_needed = components.needed;
  result.parts_left_out = components.left_out;
  result.area_left_out = components.area_left_out;
  result.guided = surface.guided();
  return result;
}

double region_error(const Partition& part, std::int32_t region) {
  const RegionSum& s = part.region_sum[region];
  return part.bound > 0 ? std::max(0.0, s.weight - 2 * part.region_normal[region].dot(Vec3(s.x, s.y, s.z))) : s.error();
}

void restate_error(const FaceGraph& graph, Partition& part) {
  part.error = 0.0;
  for (std::int32_t r = 0; r < part.region_count(); ++r) part.error += region_error(part, r) * graph.area;
  part.history = {part.error};
}

void take_how_found(Partition& part, const Partition& before) {
  part.bound = before.bound;
  part.distance_max = before.distance_max;
  part.smooth = before.smooth;
  part.metric = before.metric;
  part.off_planes = before.off_planes;
  part.tolerance = before.tolerance;
  part.noise = before.noise;
  part.snapped = before.snapped;
}

void check_is_of(const Mesh& mesh, const Partition& partition) {
  if (partition.face_region.size() != static_cast<std::size_t>(mesh.face_count()))
    throw InvalidInput("the partition has " + std::to_string(partition.face_region.size()) +
                       " faces and the mesh has " + std::to_string(mesh.face_count()) +
                       ": it was made for another mesh");
  for (std::int32_t r = 0; r < partition.region_count(); ++r) {
    const bool has_offset = !partition.region_offset.empty();
    if (!partition.region_normal[r].allFinite() || (has_offset && !std::isfinite(partition.region_offset[r])))
      throw InvalidInput("the plane of region " + std::to_string(r) + " is not finite");
  }
}

Partition partition_from(const Surface& surface, std::span<const std::int32_t> face_region, Job& job) {
  const FaceGraph& graph = surface.graph();
  if (face_region.size() != static_cast<std::size_t>(graph.size()))
    throw InvalidInput("there are " + std::to_string(face_region.size()) + " labels, but the mesh has " +
                       std::to_string(graph.size()) + " faces: give one for each");
  for (std::size_t f = 0; f < face_region.size(); ++f)
    if (face_region[f] < kNone)
      throw InvalidInput("the label of face " + std::to_string(f) + " is " + std::to_string(face_region[f]) +
                         "; labels are at least 0, or -1 for a face in no region");
  const Parts parts = parts_of(
      graph, [&](std::int32_t f) { return face_region[f]; }, job);
  if (parts.count == 0) throw InvalidInput("no face is in a region");
  Regions regions;
  regions.label.assign(graph.faces.size(), kNone);
  for (std::int32_t f = 0; f < graph.size(); ++f) regions.label[graph.graph_face[f]] = parts.of_face[f];
  regions.sum.resize(static_cast<std::size_t>(parts.count));
  sum_regions(graph, regions, job);
  Components components = find_components(surface, 1, 0.0, job);
  components.asked = parts.count;
  return make_partition(surface, components, regions, {regions.error()}, Threads(1), job);
}

void place_free_planes(const Mesh& mesh, Partition& part) {
  if (part.region_offset.empty()) return;
  struct Centre {
    Vec3 first = Vec3::Zero();
    double area = 0;
  };
  std::vector<Centre> centres(part.region_seed.size());
  const auto vertices = mesh.vertices();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t r = part.face_region[f];
    if (r == kNone || part.is_held(r)) continue;
    const auto& [a, b, c] = mesh.triangles()[f];
    const double area = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]).norm() / 2;
    centres[r].area += area;
    centres[r].first += area / 3 * (vertices[a] + vertices[b] + vertices[c]);
  }
  for (std::int32_t r = 0; r < part.region_count(); ++r) {
    const auto& [first, area] = centres[r];
    if (part.is_held(r)) continue;
    const Vec3 centre = area > 0 ? Vec3(first / area) : vertices[mesh.triangles()[part.region_seed[r]][0]];
    part.region_offset[r] = part.region_normal[r].dot(centre + mesh.origin());
  }
}

Partition inherited(Partition part, const Partition& before) {
  if (part.face_region.size() != before.face_region.size())
    throw InvalidInput("one partition has " + std::to_string(part.face_region.size()) + " faces, the other " +
                       std::to_string(before.face_region.size()));
  std::vector<std::int32_t> parent;
  for (const std::int32_t seed : part.region_seed) parent.push_back(before.face_region[seed]);
  const auto take = [&](auto& values, const auto& from) {
    if (from.empty()) return;
    values.resize(parent.size());
    for (std::size_t r = 0; r < parent.size(); ++r)
      if (parent[r] >= 0) values[r] = from[parent[r]];
  };
  take(part.region_locked, before.region_locked);
  take(part.region_held, before.region_held);
  take(part.region_cell, before.region_cell);
  part.curved = before.curved;
  if (before.bound > 0 || !before.region_held.empty()) {
    take(part.region_normal, before.region_normal);
    take(part.region_offset, before.region_offset);
  }
  take_how_found(part, before);
  part.proxies_asked = before.proxies_asked;
  part.proxies_needed = before.proxies_needed;
  part.parts_left_out = before.parts_left_out;
  part.area_left_out = before.area_left_out;
  return part;
}

}  // namespace isimp
