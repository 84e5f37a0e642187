#include "kept_part.h"

#include <algorithm>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/mesh/part_of.h"
#include "isimp/partition/keep_regions.h"

namespace isimp::meshing {
namespace {

/// Whether a face of which polygons are made borders one of which none are made, if no region is left out.
bool is_cut(const Mesh& mesh, const Partition& partition) {
  const auto& regions = partition.face_region;
  if (std::ranges::find(regions, kNone) == regions.end()) return false;  // nearly always, and quicker than all edges
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    const std::int32_t o = mesh.opposite(h);
    if (o > h && (partition.kept_region(h / 3) == kNone) != (partition.kept_region(o / 3) == kNone)) return true;
  }
  return false;
}

}  // namespace

std::optional<KeptPart> kept_part(const Mesh& mesh, const Partition& partition, Job& job) {
  const bool none_left_out =
      std::ranges::none_of(partition.region_locked, [](std::uint8_t lock) { return lock >= kLeftOut; });
  if (none_left_out && !is_cut(mesh, partition)) return std::nullopt;
  std::vector<std::int32_t> faces, source, place(partition.region_count(), kNone), region;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (const std::int32_t r = partition.kept_region(f); r != kNone) {
      faces.push_back(f);
      source.push_back(mesh.source_face().empty() ? f : mesh.source_face()[f]);
      place[r] = 0;
    }
  if (faces.empty()) throw InvalidInput("all regions are left out: there is nothing to make polygons of");
  for (std::int32_t r = 0; r < partition.region_count(); ++r)
    if (place[r] != kNone) {
      place[r] = static_cast<std::int32_t>(region.size());
      region.push_back(r);
    }
  Mesh part = part_of(mesh, faces, job, source);

  Partition kept = partition;
  kept.guided.reset();
  kept.face_region.clear();
  for (const std::int32_t f : faces) kept.face_region.push_back(place[partition.face_region[f]]);
  keep_regions(kept, region);
  for (std::int32_t& seed : kept.region_seed)
    seed = static_cast<std::int32_t>(std::ranges::lower_bound(faces, seed) - faces.begin());
  const Vec3 shift = mesh.origin() - part.origin();
  for (std::size_t r = 0; r < kept.region_offset.size(); ++r) kept.region_offset[r] += kept.region_normal[r].dot(shift);
  return KeptPart{std::move(part), std::move(kept), std::move(region)};
}

void to_whole(PolygonMesh& polygons, const KeptPart& part) {
  for (std::int32_t& r : polygons.polygon_region) r = part.region[r];
  for (std::int32_t& r : polygons.planes_let_go) r = part.region[r];
  for (std::int32_t& v : polygons.source_vertex) v = part.mesh.source_vertex()[v];
}

}  // namespace isimp::meshing
