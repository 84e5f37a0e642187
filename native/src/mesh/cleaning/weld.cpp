// Welds vertices on borders within a distance.
#include <algorithm>

#include "isimp/core/check.h"
#include "isimp/mesh/hash_grid.h"
#include "surface/soup.h"

namespace isimp::detail {

std::vector<std::int32_t> marked_indices(const std::vector<char>& marks) {
  std::vector<std::int32_t> indices;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i]) indices.push_back(static_cast<std::int32_t>(i));
  return indices;
}

std::vector<std::int32_t> border_vertices(const Soup& soup, const EdgeGroups& edges, Job& job) {
  std::vector<char> on_border(soup.vertices.size(), 0);
  edges.for_each(job, [&](const EdgeGroup& edge) {
    if (edge.size() == 1) on_border[soup.from(edge[0])] = on_border[soup.to(edge[0])] = 1;
  });
  return marked_indices(on_border);
}

bool weld(Soup& soup, const std::vector<std::int32_t>& border, double tolerance, Job& job) {
  ISIMP_ASSERT(std::ranges::is_sorted(border), "the first vertex of a place stands for the others");
  HashGrid grid(border.size(), tolerance);
  std::vector<std::int32_t> stands_for;  // (V) filled once the first pair is found
  for (std::size_t i = 0; i < border.size(); ++i) {
    if (i % kPollEvery == 0) job.poll();
    const std::int32_t v = border[i], other = grid.find_or_keep(soup.vertices, soup.vertices[v], v);
    if (other == kNone) continue;
    if (stands_for.empty()) {
      stands_for.resize(soup.vertices.size());
      for (std::size_t u = 0; u < stands_for.size(); ++u) stands_for[u] = static_cast<std::int32_t>(u);
    }
    stands_for[v] = other;
  }
  if (stands_for.empty()) return false;

  soup.welded = soup.named;
  std::vector<char> collapsed(soup.named.size(), 0);
  bool any_collapsed = false;
  for_each_index(soup.welded.size(), job, [&](std::size_t f) {
    Triangle& t = soup.welded[f];
    for (std::int32_t& v : t) v = stands_for[v];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) return;
    collapsed[f] = 1;
    any_collapsed = true;
    soup.count_face(RepairKind::repeated_index_faces, static_cast<std::int32_t>(f));
  });
  if (any_collapsed) soup.drop(collapsed);
  return true;
}

}  // namespace isimp::detail
