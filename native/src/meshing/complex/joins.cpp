#include "complex/joins.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace isimp::meshing {
namespace {

/// Whether a barrier of the partition lies between faces that would be in one chart.
bool crosses_barrier(const State& state, std::int32_t taker, const std::vector<std::int32_t>& faces) {
  if (!state.partition.guided) return false;
  const Mesh& mesh = state.mesh;
  const FaceGraph& graph = state.partition.guided->graph;
  for (const std::int32_t f : faces)
    for (std::int32_t k = 0; k < 3; ++k) {
      if (graph.neighbours[graph.graph_face[f]][k] != graph.size()) continue;
      const std::int32_t o = mesh.opposite(3 * f + k);
      if (o == kNone) continue;
      if (state.labels.label[o / 3] == taker || std::binary_search(faces.begin(), faces.end(), o / 3)) return true;
    }
  return false;
}

}  // namespace

bool parts_wall(const State& state, std::int32_t a, std::int32_t b) {
  const auto is_wall = [&](std::int32_t l) { return state.labels.charts[l].cause == Cause::wall; };
  return (state.cutter.perforated || is_wall(a) || is_wall(b)) &&
         state.planes[a].normal.dot(state.planes[b].normal) < kSameWay;
}

bool may_give(const State& state, std::int32_t giver, std::int32_t taker, const std::vector<std::int32_t>& faces) {
  const Partition& part = state.partition;
  const std::int32_t from = state.labels.charts[giver].region, to = state.labels.charts[taker].region;
  if (!part.region_locked.empty() && (part.region_locked[from] != 0 || part.region_locked[to] != 0)) return false;
  if (parts_wall(state, giver, taker) || crosses_barrier(state, taker, faces)) return false;
  if (!(part.bound > 0) || part.region_offset.empty()) return true;
  const double offset = part.offset_from(state.mesh.origin(), to);
  return std::all_of(faces.begin(), faces.end(), [&](std::int32_t f) {
    const Triangle& t = state.mesh.triangles()[f];
    return std::all_of(t.begin(), t.end(), [&](std::int32_t v) {
      const double off = part.region_normal[to].dot(state.mesh.vertices()[v]) - offset;
      return std::abs(off) <= part.bound;
    });
  });
}

bool take_back(State& state, const std::vector<bool>& defective, std::vector<Join>& joins) {
  const Labels& labels = state.labels;
  const auto is_defective = [&](std::int32_t l) { return static_cast<bool>(defective[l]); };
  std::vector<Join> kept;
  labels.vertex_marks.clear();  // the vertices of faces that undone joins moved
  std::vector<bool> goes(joins.size(), false);
  const auto vertices = [&](const Join& join, auto fn) {
    for (const std::int32_t f : join.faces)
      for (const std::int32_t v : state.mesh.triangles()[f]) fn(v);
  };
  // A join on top of an undone one must be undone before it.
  for (std::size_t i = 0; i < joins.size(); ++i) {
    goes[i] = std::any_of(joins[i].charts.begin(), joins[i].charts.end(), is_defective);
    vertices(joins[i], [&](std::int32_t v) { goes[i] = goes[i] || labels.vertex_marks.has(v); });
    if (goes[i]) vertices(joins[i], [&](std::int32_t v) { labels.vertex_marks.add(v); });
  }
  for (std::size_t i = joins.size(); i-- > 0;) {
    const Join& join = joins[i];
    if (!goes[i]) continue;
    state.hand_over(join.taker, join.giver, join.faces, join.charts);
    state.add_corner(join.gone);
  }
  for (std::size_t i = 0; i < joins.size(); ++i)
    if (!goes[i]) kept.push_back(std::move(joins[i]));
  const bool any = kept.size() < joins.size();
  joins = std::move(kept);
  return any;
}

}  // namespace isimp::meshing
