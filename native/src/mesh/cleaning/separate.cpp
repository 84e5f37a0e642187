// Separates fans of faces that share only a vertex.
#include <algorithm>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "isimp/mesh/mesh.h"
#include "surface/soup.h"

namespace isimp::detail {
namespace {

/// The fans of faces at vertices.
struct Fans {
  std::vector<std::int32_t> of_corner;  ///< (3 F)
  std::vector<std::int32_t> source;     ///< the first of the caller's vertices that meet in each
};

Fans find_fans(const Soup& soup, Job& job) {
  Fans fans;
  const auto corners = static_cast<std::int32_t>(3 * soup.named.size());
  fans.of_corner.assign(corners, kNone);
  for (std::int32_t c = 0; c < corners; ++c) {
    if (c % kPollEvery == 0) job.poll();
    if (fans.of_corner[c] != kNone) continue;
    const auto id = static_cast<std::int32_t>(fans.source.size());
    std::int32_t first = soup.named[c / 3][c % 3];
    const auto visit = [&](std::int32_t h) {
      fans.of_corner[h] = id;
      first = std::min(first, soup.named[h / 3][h % 3]);
    };
    std::int32_t h = c;
    do {  // counter-clockwise, a full turn or up to a border
      visit(h);
      h = soup.opposite[Mesh::prev(h)];
    } while (h != kNone && h != c);
    if (h == kNone)
      for (h = soup.opposite[c]; h != kNone; h = soup.opposite[h]) visit(h = Mesh::next(h));
    fans.source.push_back(first);
  }
  return fans;
}

/// Numbers the fans as vertices: the caller's vertices in their order, each for its first fan, then the copies.
std::vector<std::int32_t> number_fans(Soup& soup, const Fans& fans, Array<std::int32_t>& source_vertex) {
  const std::size_t n = soup.vertices.size();
  std::vector<std::int32_t> first_fan(n, kNone), vertex(fans.source.size(), kNone);
  for (std::size_t fan = 0; fan < fans.source.size(); ++fan)
    if (std::int32_t& first = first_fan[fans.source[fan]]; first == kNone) first = static_cast<std::int32_t>(fan);

  std::vector<char> used;
  if (!soup.welded.empty()) {
    used.assign(n, 0);
    for (const Triangle& t : soup.named)
      for (const std::int32_t v : t) used[v] = 1;
  }
  source_vertex.clear();
  for (std::size_t v = 0; v < n; ++v) {
    const auto caller = static_cast<std::int32_t>(v);
    if (first_fan[v] != kNone) {
      vertex[first_fan[v]] = static_cast<std::int32_t>(source_vertex.size());
      source_vertex.push_back(caller);
    } else {
      soup.log.add(!used.empty() && used[v] ? RepairKind::welded_vertices : RepairKind::unused_vertices, caller);
    }
  }
  for (std::size_t fan = 0; fan < vertex.size(); ++fan) {
    if (vertex[fan] != kNone) continue;
    vertex[fan] = static_cast<std::int32_t>(source_vertex.size());
    source_vertex.push_back(fans.source[fan]);
    soup.log.add(RepairKind::split_vertices, fans.source[fan]);
  }
  return vertex;
}

/// Halves edges by a new vertex, and the one or two faces of each.
class Halver {
 public:
  Halver(MeshArrays& arrays, std::vector<std::int32_t>& opposite) : arrays_(arrays), opposite_(opposite) {}

  void halve(std::int32_t half_edge) {
    const std::int32_t g = present(half_edge), h = opposite_[g];
    const Triangle& t = arrays_.triangles[g / 3];
    const Vec3 middle = (arrays_.vertices[t[g % 3]] + arrays_.vertices[t[(g + 1) % 3]]) / 2;
    const auto m = static_cast<std::int32_t>(arrays_.vertices.size());
    arrays_.vertices.push_back(middle);
    arrays_.source_vertex.push_back(kNone);
    const std::int32_t g_end = split_face(g, m);
    if (h == kNone) return;
    const std::int32_t h_end = split_face(h, m);
    join(g, h_end);
    join(g_end, h);
  }

 private:
  /// Splits face (a, b, c) at half-edge h from a to b into (a, m, c) and a new (m, b, c). Returns the half-edge m to b.
  std::int32_t split_face(std::int32_t h, std::int32_t m) {
    const auto fresh = static_cast<std::int32_t>(3 * arrays_.triangles.size());
    const std::int32_t next = Mesh::next(h);
    Triangle& t = arrays_.triangles[h / 3];
    const Triangle rest{m, t[next % 3], t[Mesh::prev(h) % 3]};
    t[next % 3] = m;
    arrays_.triangles.push_back(rest);
    arrays_.source_face.push_back(arrays_.source_face[h / 3]);
    opposite_.insert(opposite_.end(), 3, kNone);
    if (const std::int32_t beyond = opposite_[next]; beyond != kNone) join(fresh + 1, beyond);
    join(next, fresh + 2);
    moved_[next] = fresh + 1;
    return fresh;
  }
  void join(std::int32_t g, std::int32_t h) {
    opposite_[g] = h;
    opposite_[h] = g;
  }
  /// The present number of a half-edge.
  [[nodiscard]] std::int32_t present(std::int32_t h) const {
    for (auto at = moved_.find(h); at != moved_.end(); at = moved_.find(h)) h = at->second;
    return h;
  }

  MeshArrays& arrays_;
  std::vector<std::int32_t>& opposite_;
  std::unordered_map<std::int32_t, std::int32_t> moved_;
};

/// A split edge may still be two edges with the same ends, where its faces are connected elsewhere.
void halve_double_edges(MeshArrays& arrays, Soup& soup) {
  std::vector<std::tuple<std::int32_t, std::int32_t, std::int32_t>> edges;  // smaller end, larger end, half-edge
  for (const std::int32_t h : soup.contested) {
    const Triangle& t = arrays.triangles[h / 3];
    const auto [low, high] = std::minmax(t[h % 3], t[(h + 1) % 3]);
    edges.emplace_back(low, high, soup.opposite[h] == kNone ? h : std::min(h, soup.opposite[h]));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  Halver halver(arrays, soup.opposite);
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const auto& [low, high, h] = edges[i];
    if (std::get<0>(edges[i - 1]) != low || std::get<1>(edges[i - 1]) != high) continue;
    soup.log.add(RepairKind::subdivided_edges, arrays.source_face[h / 3]);
    halver.halve(h);
  }
}

}  // namespace

MeshArrays separate(Soup& soup, Job& job) {
  MeshArrays arrays;
  const Fans fans = find_fans(soup, job);
  const std::vector<std::int32_t> vertex = number_fans(soup, fans, arrays.source_vertex);
  job.poll();
  arrays.triangles = std::move(soup.named);
  arrays.source_face = std::move(soup.source_face);
  for_each_index(arrays.triangles.size(), job, [&](std::size_t f) {
    for (std::size_t k = 0; k < 3; ++k) arrays.triangles[f][k] = vertex[fans.of_corner[3 * f + k]];
  });
  arrays.vertices.reserve(arrays.source_vertex.size());
  for (const std::int32_t v : arrays.source_vertex) arrays.vertices.push_back(soup.vertices[v]);
  halve_double_edges(arrays, soup);
  return arrays;
}

}  // namespace isimp::detail
