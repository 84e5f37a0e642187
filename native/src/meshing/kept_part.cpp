#include "kept_part.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/mesh/part_of.h"
#include "isimp/partition/keep_regions.h"

namespace isimp::meshing {
namespace {

/// The graph of a part with the barriers between its faces; null if there are none.
/// \param faces  of the whole, by face of the part
std::shared_ptr<const GuidedGraph> guided_part(const Surface& whole, const Mesh& part,
                                               const std::vector<std::int32_t>& faces, Job& job) {
  if (!whole.guided()) return nullptr;
  const FaceGraph& graph = whole.graph();
  Guides guides;
  for (std::int32_t h = 0; h < 3 * part.face_count(); ++h) {
    const std::int32_t of_whole = graph.graph_face[faces[h / 3]];
    if (part.opposite(h) > h && graph.neighbours[of_whole][h % 3] == graph.size())
      guides.barriers.push_back({part.from(h), part.to(h)});
  }
  return Surface(part, guides, job).guided();
}

}  // namespace

std::optional<KeptPart> kept_part(const Mesh& mesh, const Partition& partition, Job& job) {
  const auto is_kept = [&](std::int32_t f) { return partition.kept_region(f) != kNone; };
  std::int32_t first = 0;
  while (first < mesh.face_count() && is_kept(first)) ++first;
  if (first == mesh.face_count()) return std::nullopt;
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
  kept.guided = guided_part(Surface(mesh, partition.guided), part, faces, job);
  kept.face_region.clear();
  for (const std::int32_t f : faces) kept.face_region.push_back(place[partition.face_region[f]]);
  keep_regions(kept, region);
  for (std::int32_t& seed : kept.region_seed)
    seed = static_cast<std::int32_t>(std::ranges::lower_bound(faces, seed) - faces.begin());
  return KeptPart{std::move(part), std::move(kept), std::move(region), std::move(faces)};
}

void to_whole(PolygonMesh& polygons, const KeptPart& part) {
  for (std::int32_t& r : polygons.polygon_region) r = part.region[r];
  for (std::int32_t& r : polygons.planes_let_go) r = part.region[r];
  for (std::int32_t& v : polygons.source_vertex) v = part.mesh.source_vertex()[v];
}

}  // namespace isimp::meshing
