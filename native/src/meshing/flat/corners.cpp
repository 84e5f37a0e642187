#include <algorithm>
#include <cmath>
#include <utility>

#include "discs/polyline.h"
#include "flat/flat.h"

namespace isimp::meshing::flat {
namespace {

/// (V) the number of edges at each vertex where regions end.
std::vector<std::int32_t> border_edges(const Mesh& mesh, const Regions& regions) {
  std::vector<std::int32_t> count(mesh.vertex_count(), 0);
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    const std::int32_t other = mesh.opposite(h);
    const bool once = other == kNone || (h < other && regions.label[Mesh::face(other)] != regions.label[Mesh::face(h)]);
    if (!once) continue;
    ++count[mesh.from(h)];
    ++count[mesh.to(h)];
  }
  return count;
}

/// Marks the corners of a chain of vertices between two corners. Ties go to the lowest vertex, so that the chain walked
/// the other way has the same corners.
void mark_bends(const Mesh& mesh, const Loop& chain, double far, std::vector<char>& is_corner) {
  std::vector<std::pair<std::size_t, std::size_t>> parts{{0, chain.size() - 1}};
  while (!parts.empty()) {
    const auto [begin, end] = parts.back();
    parts.pop_back();
    double most = far;
    std::size_t farthest = begin;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double away = std::sqrt(
          squared_distance(mesh.vertices()[chain[i]], mesh.vertices()[chain[begin]], mesh.vertices()[chain[end]]));
      if (away > most || (away == most && farthest != begin && chain[i] < chain[farthest])) {
        most = away;
        farthest = i;
      }
    }
    if (farthest == begin) continue;
    is_corner[chain[farthest]] = 1;
    parts.emplace_back(begin, farthest);
    parts.emplace_back(farthest, end);
  }
}

/// Marks two corners of a loop without any: the vertex that is farthest from its lowest one, and that farthest from it.
void begin_loop(const Mesh& mesh, const Loop& loop, std::vector<char>& is_corner) {
  std::int32_t from = *std::min_element(loop.begin(), loop.end());
  for (int round = 0; round < 2; ++round) {
    const auto away = [&](std::int32_t v) { return (mesh.vertices()[v] - mesh.vertices()[from]).squaredNorm(); };
    from = *std::max_element(loop.begin(), loop.end(), [&](std::int32_t a, std::int32_t b) {
      return away(a) != away(b) ? away(a) < away(b) : a > b;
    });
    is_corner[from] = 1;
  }
}

}  // namespace

void mark_corners(const Mesh& mesh, const Regions& regions, const std::vector<std::vector<Loop>>& loops,
                  std::span<const char> as_it_is, std::vector<char>& is_corner) {
  const std::vector<std::int32_t> edges = border_edges(mesh, regions);
  is_corner.assign(mesh.vertex_count(), 0);
  for (std::size_t v = 0; v < edges.size(); ++v) is_corner[v] = edges[v] > 2 ? 1 : 0;
  for (std::int32_t r = 0; r < regions.count(); ++r) {
    if (as_it_is[r] == 0) continue;
    for (const std::int32_t f : regions.faces(r)) {
      for (const std::int32_t v : mesh.triangles()[f]) is_corner[v] = 1;
    }
  }
  const std::vector<char> given = is_corner;
  const double far = kSame * mesh.diagonal();
  for (const auto& of_region : loops) {
    for (const Loop& loop : of_region) {
      const bool is_free = std::none_of(loop.begin(), loop.end(), [&](std::int32_t v) { return given[v] != 0; });
      if (is_free) begin_loop(mesh, loop, is_corner);
      std::vector<char> ends;
      for (const std::int32_t v : loop) ends.push_back(is_free ? is_corner[v] : given[v]);
      const auto first = static_cast<std::size_t>(std::find(ends.begin(), ends.end(), 1) - ends.begin());
      Loop chain{loop[first]};
      for (std::size_t i = 1; i <= loop.size(); ++i) {
        const std::size_t at = (first + i) % loop.size();
        chain.push_back(loop[at]);
        if (ends[at] == 0) continue;
        mark_bends(mesh, chain, far, is_corner);
        chain.assign(1, loop[at]);
      }
    }
  }
}

}  // namespace isimp::meshing::flat
