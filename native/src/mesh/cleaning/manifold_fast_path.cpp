#include "isimp/mesh/mesh.h"
#include "surface/soup.h"

/// The short way through `clean` for input that is manifold already, as most files are.
namespace isimp::detail {

bool has_twins(const Topology& topology, const Threads& threads) {
  const Array<std::int32_t>& opposite = topology.opposite;
  const std::size_t faces = opposite.size() / 3;
  const auto is_twin = [&](std::size_t f) {
    const std::int32_t g = opposite[3 * f], other = g / 3;
    if (opposite[3 * f + 1] / 3 != other || opposite[3 * f + 2] / 3 != other) return false;
    return g != kNone && opposite[3 * f + 1] != kNone && opposite[3 * f + 2] != kNone;
  };
  return find_first(threads, faces, is_twin) < faces;
}

std::vector<std::int32_t> border_vertices(const Soup& soup, const Topology& topology) {
  std::vector<char> on_border(topology.border.empty() ? 0 : soup.vertices.size(), 0);
  for (const std::int32_t h : topology.border) on_border[soup.from(h)] = 1;  // loops: every end is a start too
  return marked_indices(on_border);
}

MeshArrays compact(Soup& soup, Topology& topology, const Threads& threads, Job& job) {
  MeshArrays arrays;
  const bool renamed = !soup.welded.empty();
  if (renamed || topology.unused_vertices > 0) {
    std::vector<char> named(renamed ? soup.vertices.size() : 0, 0);
    if (renamed)
      for (const Triangle& t : soup.named)
        for (const std::int32_t v : t) named[v] = 1;
    std::vector<std::int32_t> vertex(soup.vertices.size(), kNone);
    std::size_t kept = 0;
    for_each_index(vertex.size(), job, [&](std::size_t v) {
      const auto caller = static_cast<std::int32_t>(v);
      if (topology.vertex_halfedge[v] == kNone) {
        soup.log.add(renamed && named[v] ? RepairKind::welded_vertices : RepairKind::unused_vertices, caller);
        return;
      }
      soup.vertices[kept] = soup.vertices[v];
      topology.vertex_halfedge[kept] = topology.vertex_halfedge[v];
      vertex[v] = static_cast<std::int32_t>(kept++);
      arrays.source_vertex.push_back(caller);
    });
    soup.vertices.resize(kept);
    topology.vertex_halfedge.resize(kept);
    topology.unused_vertices = 0;
    if (renamed) soup.named = std::move(soup.welded);
    for_each_index(threads, soup.named.size(), job, [&](std::size_t f) {
      for (std::int32_t& v : soup.named[f]) v = vertex[v];
    });
  }
  arrays.vertices = std::move(soup.vertices);
  arrays.triangles = std::move(soup.named);
  arrays.source_face = std::move(soup.source_face);
  return arrays;
}

}  // namespace isimp::detail
