// Finds the half-edge between two vertices.
#include "isimp/mesh/find_edge.h"

namespace isimp {

std::int32_t find_edge(const Mesh& mesh, std::int32_t a, std::int32_t b) {
  if (a < 0 || b < 0 || a >= mesh.vertex_count() || b >= mesh.vertex_count()) return kNone;
  const std::int32_t start = mesh.vertex_halfedge()[a];
  for (std::int32_t h = start; h != kNone;) {
    if (mesh.to(h) == b) return h;
    if (mesh.from(Mesh::prev(h)) == b) return Mesh::prev(h);  // only this way on a border
    h = mesh.next_outgoing(h);
    if (h == start) break;
  }
  return kNone;
}

}  // namespace isimp
