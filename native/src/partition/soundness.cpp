#include "isimp/partition/soundness.h"

#include <cmath>
#include <vector>

namespace isimp {
namespace {

std::string region_text(std::int32_t region) { return "region " + std::to_string(region); }

/// The arrays that have one value for each region, or none.
std::string broken_sizes(const Partition& p) {
  const std::size_t regions = p.region_seed.size();
  if (p.region_normal.size() != regions) return "there must be a normal for each region";
  if (p.region_sum.size() != regions) return "there must be a sum for each region";
  if (!p.region_locked.empty() && p.region_locked.size() != regions) return "region_locked has another size";
  if (!p.region_held.empty() && p.region_held.size() != regions) return "region_held has another size";
  if (!p.region_offset.empty() && p.region_offset.size() != regions) return "region_offset has another size";
  if (!p.region_cell.empty() && p.region_cell.size() != regions) return "region_cell has another size";
  for (const CurvedCell& c : p.region_cell)
    if (c.proxy < kNone || c.proxy >= static_cast<std::int32_t>(p.curved.size())) return "a cell is of no patch";
  return "";
}

}  // namespace

std::int32_t find_unconnected(const Surface& surface, std::span<const std::int32_t> face_region, std::int32_t regions) {
  const FaceGraph& graph = surface.graph();
  std::vector<std::uint8_t> met(static_cast<std::size_t>(regions), 0), seen(face_region.size(), 0);
  std::vector<std::int32_t> stack;
  for (std::int32_t f = 0; f < graph.size(); ++f) {
    const std::int32_t region = face_region[f];
    if (region == kNone || seen[f] != 0) continue;
    if (met[region] != 0) return region;
    met[region] = seen[f] = 1;
    stack.push_back(graph.graph_face[f]);
    while (!stack.empty()) {
      const std::int32_t i = stack.back();
      stack.pop_back();
      for (const std::int32_t j : graph.neighbours[i]) {
        if (j == graph.size()) continue;
        const std::int32_t g = graph.mesh_face[j];
        if (seen[g] != 0 || face_region[g] != region) continue;
        seen[g] = 1;
        stack.push_back(j);
      }
    }
  }
  return kNone;
}

std::string broken_promise(const Surface& surface, const Partition& p) {
  if (p.face_region.size() != static_cast<std::size_t>(surface.face_count()))
    return "there must be a label for each face";
  if (std::string broken = broken_sizes(p); !broken.empty()) return broken;
  std::vector<std::int32_t> faces(p.region_seed.size(), 0);
  for (std::size_t f = 0; f < p.face_region.size(); ++f) {
    const std::int32_t region = p.face_region[f];
    if (region < kNone || region >= p.region_count())
      return "face " + std::to_string(f) + " has label " + std::to_string(region);
    if (region != kNone) ++faces[region];
  }
  for (std::int32_t r = 0; r < p.region_count(); ++r) {
    const std::int32_t seed = p.region_seed[r];
    if (faces[r] == 0) return region_text(r) + " is empty";
    if (seed < 0 || seed >= surface.face_count() || p.face_region[seed] != r)
      return region_text(r) + " has a seed outside it";
    if (p.region_sum[r].faces != faces[r]) return region_text(r) + " has a sum of another number of faces";
    const double length = p.region_normal[r].norm();
    if (!(std::abs(length - 1) < 1e-6) && length != 0) return region_text(r) + " has a normal that is not unit";
  }
  const std::int32_t loose = find_unconnected(surface, p.face_region, p.region_count());
  return loose == kNone ? "" : region_text(loose) + " is not connected";
}

}  // namespace isimp
