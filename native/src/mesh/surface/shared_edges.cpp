// Pairs triangles that share an edge.
#include "isimp/mesh/shared_edges.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "surface/edge_groups.h"

namespace isimp {

namespace {

void append(SharedEdges& to, const SharedEdges& from) {
  to.edges.insert(to.edges.end(), from.edges.begin(), from.edges.end());
  to.face.insert(to.face.end(), from.face.begin(), from.face.end());
  to.beside.insert(to.beside.end(), from.beside.begin(), from.beside.end());
}

}  // namespace

SharedEdges shared_edges(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) {
  const detail::EdgeGroups groups(vertex_count, triangles, job);
  SharedEdges found, next_but_one;
  const std::size_t about = triangles.size() + triangles.size() / 2;
  found.edges.reserve(about);
  found.face.reserve(about);
  found.beside.reserve(about);
  groups.for_each(job, [&](const detail::EdgeGroup& group) {
    const std::int32_t h = group[0];
    const std::int32_t from = triangles[h / 3][h % 3], to = triangles[h / 3][(h + 1) % 3];
    const auto pair = [&](SharedEdges& to_these, std::size_t i, std::size_t j) {
      to_these.edges.push_back({std::min(from, to), std::max(from, to)});
      to_these.face.push_back(group[i] / 3);
      to_these.beside.push_back(group[j] / 3);
    };
    for (std::size_t i = 1; i < group.size(); ++i) pair(found, i - 1, i);
    for (std::size_t i = 2; i < group.size(); ++i) pair(next_but_one, i - 2, i);
  });
  append(found, next_but_one);
  return found;
}

}  // namespace isimp
