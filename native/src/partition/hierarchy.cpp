#include "isimp/partition/hierarchy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace isimp {
namespace {

constexpr std::int32_t kWidestTile = 32;  // one bit a face
constexpr std::int32_t kTilesARegion = 12;
constexpr float kCrease = 0.95F;          // cosine: neighbours that differ by more are never in one patch
constexpr std::int32_t kCoarsest = 64;    // nodes, where the rounds end
constexpr std::int32_t kLeastOfPart = 8;  // nodes of a component, below which rounds leave it alone

std::int32_t tile_for(std::int32_t faces, std::int32_t proxies) {
  const std::int64_t room = faces / (static_cast<std::int64_t>(kTilesARegion) * proxies);
  std::int32_t tile = kWidestTile;
  while (tile > 1 && tile > room) tile /= 2;
  return tile;
}

/// Patches within one tile, by sets of faces as bits of a word.
class Tile {
 public:
  void read(const FaceGraph& graph, std::int32_t begin, std::int32_t count) {
    for (std::int32_t i = 0; i < count; ++i) {
      const FaceRecord& f = graph.faces[begin + i];
      std::uint32_t joined = 0;
      for (const std::int32_t j : graph.neighbours[begin + i]) {
        const auto at = static_cast<std::uint32_t>(j - begin);
        const std::uint32_t inside = at < static_cast<std::uint32_t>(count) ? at : static_cast<std::uint32_t>(i);
        const FaceRecord& g = graph.faces[begin + static_cast<std::int32_t>(inside)];
        joined |= static_cast<std::uint32_t>(f.nx * g.nx + f.ny * g.ny + f.nz * g.nz >= kCrease) << inside;
      }
      joined_[i] = joined;
    }
    left_ = count == 32 ? ~0U : (1U << count) - 1;
  }
  [[nodiscard]] bool empty() const { return left_ == 0; }
  /// The next patch: calls `visit` with the place of each of its faces in the tile.
  template <class Visit>
  void take(Visit visit) {
    std::uint32_t border = left_ & (~left_ + 1);
    left_ &= ~border;
    while (border != 0) {
      const int i = std::countr_zero(border);
      border &= border - 1;
      const std::uint32_t fresh = joined_[i] & left_;
      left_ &= ~fresh;
      border |= fresh;
      visit(i);
    }
  }

 private:
  std::uint32_t joined_[32];
  std::uint32_t left_ = 0;
};

void make_patches(const FaceGraph& graph, Hierarchy& h, std::vector<NodeSum>& sums, Job& job) {
  const std::int32_t n = graph.size();
  h.patch.resize(static_cast<std::size_t>(n));
  h.patch_face.resize(static_cast<std::size_t>(n));
  h.patch_first.clear();
  Tile tile;
  std::int32_t out = 0;
  for (std::int32_t begin = 0; begin < n; begin += h.tile) {
    if ((begin & 0xffff) == 0) job.poll();
    tile.read(graph, begin, std::min(h.tile, n - begin));
    while (!tile.empty()) {
      const auto id = static_cast<std::int32_t>(h.patch_first.size());
      h.patch_first.push_back(out);
      NodeSum s;
      tile.take([&](int i) {
        const FaceRecord& f = graph.faces[begin + i];
        s.x += f.area * f.nx;
        s.y += f.area * f.ny;
        s.z += f.area * f.nz;
        h.patch_face[out++] = begin + i;
        h.patch[begin + i] = id;
      });
      s.length = std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z);
      sums.push_back(s);
    }
  }
  h.patch_first.push_back(n);
}

MergeGraph graph_of_patches(const Surface& surface, const Hierarchy& h, std::vector<NodeSum> sums, Job& job) {
  const FaceGraph& faces = surface.graph();
  const std::int32_t n = faces.size();
  MergeGraph graph;
  graph.sum = std::move(sums);
  const std::int32_t patches = graph.size();
  graph.first.resize(static_cast<std::size_t>(patches) + 1);
  graph.neighbour.resize(3 * static_cast<std::size_t>(n) + 1);
  std::vector<std::int32_t> seen(static_cast<std::size_t>(patches) + 1, -1);
  std::int32_t out = 0;
  for (std::int32_t p = 0; p < patches; ++p) {
    if ((p & 0xfff) == 0) job.poll();
    graph.first[p] = out;
    seen[p] = p;
    seen[patches] = p;  // stands for the outside
    for (std::int32_t k = h.patch_first[p]; k < h.patch_first[p + 1]; ++k)
      for (const std::int32_t j : faces.neighbours[h.patch_face[k]]) {
        const std::int32_t other = j == n ? patches : h.patch[j];
        graph.neighbour[out] = other;
        out += seen[other] != p;
        seen[other] = p;
      }
  }
  graph.first[patches] = out;
  graph.neighbour.resize(static_cast<std::size_t>(out));
  if (surface.component_count() > 1) {
    graph.part.resize(static_cast<std::size_t>(patches));
    for (std::int32_t p = 0; p < patches; ++p)
      graph.part[p] = surface.component()[faces.mesh_face[h.patch_face[h.patch_first[p]]]];
  }
  return graph;
}

}  // namespace

bool Hierarchy::serves(const Surface& surface, std::int32_t proxies) const {
  return patch.size() == static_cast<std::size_t>(surface.face_count()) &&
         tile == tile_for(surface.face_count(), proxies);
}

Hierarchy build_hierarchy(const Surface& surface, std::int32_t proxies, Job& job) {
  Job::Part stage(job, "merging", 0.0, 1.0);
  Hierarchy h;
  h.tile = tile_for(surface.face_count(), proxies);
  std::vector<NodeSum> sums;
  make_patches(surface.graph(), h, sums, job);

  job.report(0.3);
  h.level.push_back(graph_of_patches(surface, h, std::move(sums), job));

  job.report(0.6);
  while (h.level.back().size() > kCoarsest) {
    const bool satellites = h.level.size() <= 2;
    std::vector<std::int32_t> map;
    MergeGraph next = merge_round(h.level.back(), satellites, kLeastOfPart, map, job);
    // The gate lets at least a few pairs pass, unless every component is down to its least.
    if (next.size() == h.level.back().size()) break;
    h.to_next.push_back(std::move(map));
    h.level.push_back(std::move(next));
  }

  return h;
}

}  // namespace isimp
