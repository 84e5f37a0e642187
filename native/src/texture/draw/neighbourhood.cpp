// Groups the faces of regions and their neighbours for the bake.
#include <algorithm>
#include <array>

#include "draw/view.h"

namespace isimp::detail {
namespace {

/// Pairs of regions that share an edge, both ways, rising.
std::vector<std::array<std::int32_t, 2>> beside(const Mesh& mesh, const Partition& partition) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  const auto& region = partition.face_region;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    const std::int32_t o = mesh.opposite(h);
    if (o == kNone) continue;
    const std::int32_t a = region[Mesh::face(h)], b = region[Mesh::face(o)];
    if (a != b && a >= 0 && b >= 0 && (pairs.empty() || pairs.back() != std::array{a, b})) pairs.push_back({a, b});
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

void make_blocks(const Mesh& mesh, Neighbourhood& found) {
  std::vector<std::int32_t> place(mesh.vertex_count(), kNone);
  found.corners.resize(found.faces.size());
  for (std::size_t r = 0; r + 1 < found.start.size(); ++r) {
    found.block_start.push_back(static_cast<std::int32_t>(found.blocks.size()));
    for (std::int32_t begin = found.start[r]; begin < found.start[r + 1]; begin += Neighbourhood::kBlock) {
      Neighbourhood::Block block{begin,
                                 std::min(begin + Neighbourhood::kBlock, found.start[r + 1]),
                                 static_cast<std::int32_t>(found.vertices.size()),
                                 0,
                                 Vec3::Zero(),
                                 0};
      Box box;
      for (std::int32_t i = block.begin; i < block.end; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
          const std::int32_t v = mesh.triangles()[found.faces[i]][k];
          if (place[v] == kNone) {
            place[v] = block.count++;
            found.vertices.push_back(v);
            box.extend(mesh.vertices()[v]);
          }
          found.corners[i][k] = static_cast<std::uint8_t>(place[v]);
        }
      for (std::int32_t i = block.first; i < block.first + block.count; ++i) place[found.vertices[i]] = kNone;
      block.middle = box.center();
      block.radius = box.diagonal().norm() / 2;
      found.blocks.push_back(block);
    }
  }
  found.block_start.push_back(static_cast<std::int32_t>(found.blocks.size()));
}

}  // namespace

Neighbourhood find_neighbourhood(const Mesh& mesh, const Partition& partition, std::span<const std::uint8_t> known) {
  Neighbourhood found;
  const std::int32_t regions = partition.region_count();
  const auto& region = partition.face_region;
  const auto counts = [&](std::int32_t f) { return region[f] >= 0 && (known.empty() || known[f] != 0); };
  found.start.assign(regions + 1, 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (counts(f)) ++found.start[region[f] + 1];
  for (std::int32_t r = 0; r < regions; ++r) found.start[r + 1] += found.start[r];
  found.faces.resize(found.start[regions]);
  std::vector<std::int32_t> end(found.start.begin(), found.start.end() - 1);
  for (const std::int32_t f : mesh.graph().mesh_face)
    if (counts(f)) found.faces[end[region[f]]++] = f;
  make_blocks(mesh, found);

  const auto pairs = beside(mesh, partition);
  std::vector<std::int32_t> first(regions + 1, 0);
  for (const auto& [a, b] : pairs) ++first[a + 1];
  for (std::int32_t r = 0; r < regions; ++r) first[r + 1] += first[r];
  std::vector<std::int32_t> seen(regions, kNone);
  const auto has_faces = [&](std::int32_t r) { return found.start[r + 1] > found.start[r]; };
  for (std::int32_t r = 0; r < regions; ++r) {
    const std::size_t begin = found.near.size();
    found.near_start.push_back(static_cast<std::int32_t>(begin));
    found.near.push_back(r);
    seen[r] = r;
    for (std::size_t ring = begin; ring < found.near.size();) {
      const std::size_t ring_end = found.near.size();
      for (; ring < ring_end; ++ring)
        for (std::int32_t i = first[found.near[ring]]; i < first[found.near[ring] + 1]; ++i)
          if (const std::int32_t b = pairs[i][1]; seen[b] != r) {
            seen[b] = r;
            found.near.push_back(b);
          }
      if (std::any_of(found.near.begin() + static_cast<std::ptrdiff_t>(begin), found.near.end(), has_faces)) break;
    }
  }
  found.near_start.push_back(static_cast<std::int32_t>(found.near.size()));
  return found;
}

}  // namespace isimp::detail
