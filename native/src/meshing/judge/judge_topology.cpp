// Counts edges and vertices that are not manifold.
#include <algorithm>
#include <vector>

#include "isimp/core/forest.h"
#include "judge/judge.h"

namespace isimp::meshing {
namespace {

struct LoopEdge {
  std::int32_t a, b;    // a < b
  std::int32_t corner;  // where in `loops` it starts
  bool forward;         // from a to b
  auto operator<=>(const LoopEdge&) const = default;
};

}  // namespace

void judge_topology(PolygonMesh& mesh) {
  std::vector<LoopEdge> edges;
  std::vector<std::int32_t> next(mesh.loops.size());
  for (std::int32_t q = 0; q < mesh.polygon_count(); ++q) {
    const std::int32_t begin = mesh.loop_start[q], end = mesh.loop_end(q);
    for (std::int32_t i = begin; i < end; ++i) {
      next[i] = i + 1 < end ? i + 1 : begin;
      const std::int32_t a = mesh.loops[i], b = mesh.loops[next[i]];
      edges.push_back({std::min(a, b), std::max(a, b), i, a < b});
    }
  }
  std::sort(edges.begin(), edges.end());
  detail::Forest fans(mesh.loops.size());  // corners of a vertex whose polygons meet in an edge
  std::size_t groups = mesh.loops.size();
  bool good = true, closed = true;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b) ++end;
    ++count;
    closed = closed && end - i == 2;
    if (end - i > 2 || edges[i].a == edges[i].b || (end - i == 2 && edges[i].forward == edges[i + 1].forward)) {
      good = false;
    } else if (end - i == 2) {
      groups -= fans.join(edges[i].corner, next[edges[i + 1].corner]) ? 1 : 0;
      groups -= fans.join(edges[i + 1].corner, next[edges[i].corner]) ? 1 : 0;
    }
    i = end;
  }
  mesh.report.closed = closed;
  mesh.report.manifold = good && groups == mesh.vertices.size();
  mesh.report.euler = static_cast<std::int64_t>(mesh.vertices.size()) - count + mesh.polygon_count();
}

}  // namespace isimp::meshing
