// Cuts the handles of a chart.
#include <algorithm>
#include <queue>
#include <tuple>
#include <unordered_map>

#include "discs/discs.h"

namespace isimp::meshing {
namespace {

constexpr int kLoopTries = 200;  ///< limit: loops that do not lower genus, before the others are left alone

struct HandleLoop {
  double length = 0;
  std::vector<std::int32_t> vertices;
};

/// A tree over the vertices by distance from one, and a tree over the faces that crosses none of its edges. Each of the
/// remaining edges closes a loop along a handle, two a handle.
class Trees {
 public:
  Trees(Cutter& cutter, std::int32_t chart, std::span<const std::int32_t> faces, const Shape& shape)
      : cutter_(cutter), mesh_(cutter.labels.mesh), chart_(chart), faces_(faces), shape_(shape) {}

  std::vector<HandleLoop> handle_loops() {
    grow_vertex_tree();
    grow_face_tree();
    std::vector<HandleLoop> loops;
    for (const std::int32_t f : faces_)
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        const bool first = !cutter_.labels.inner(h) || h < mesh_.opposite(h);
        if (first && !in_tree(h) && !cutter_.halfedge_marks.has(h)) loops.push_back(loop_of(h));
      }
    std::stable_sort(loops.begin(), loops.end(),
                     [](const HandleLoop& a, const HandleLoop& b) { return a.length < b.length; });
    return loops;
  }

 private:
  [[nodiscard]] double edge_length(std::int32_t a, std::int32_t b) const {
    return (mesh_.vertices()[a] - mesh_.vertices()[b]).norm();
  }
  [[nodiscard]] bool in_tree(std::int32_t h) const {
    const std::int32_t a = mesh_.from(h), b = mesh_.to(h);
    return cutter_.vertices.via[a] == b || cutter_.vertices.via[b] == a;
  }

  void grow_vertex_tree() {
    Search& search = cutter_.vertices;
    search.start();
    search.reach(mesh_.from(3 * faces_[0]), 0, kNone);
    for (std::int32_t v = search.take(); v != kNone; v = search.take())
      for_each_leaving(mesh_, v, [&](std::int32_t h) {
        if (cutter_.labels.label[h / 3] != chart_) return;
        const auto reach = [&](std::int32_t w) { search.reach(w, search.distance[v] + edge_length(v, w), v); };
        reach(mesh_.to(h));
        if (!cutter_.labels.inner(Mesh::prev(h))) reach(mesh_.from(Mesh::prev(h)));
      });
  }

  /// Grows the tree over edges with the longest loops first, so that the short loops remain.
  void grow_face_tree() {
    std::unordered_map<std::int32_t, std::int32_t> loop_of_edge;
    for (std::size_t i = 0; i < shape_.loops.size(); ++i)
      for (const std::int32_t h : shape_.loops[i]) loop_of_edge[h] = static_cast<std::int32_t>(i);
    // Loop length, half-edge, whether it leads in from a hole.
    std::priority_queue<std::tuple<double, std::int32_t, bool>> queue;
    const auto face_behind = [&](std::int32_t h, bool from_hole) { return from_hole ? h / 3 : mesh_.opposite(h) / 3; };
    const auto leads_out = [&](std::int32_t h, bool from_hole) { return !from_hole && !cutter_.labels.inner(h); };
    const auto push = [&](std::int32_t h, bool from_hole) {
      // Most edges are met a second time, from the face that the tree has reached over them.
      if (!leads_out(h, from_hole) && cutter_.face_marks.has(face_behind(h, from_hole))) return;
      if (in_tree(h)) return;
      const Search& s = cutter_.vertices;
      queue.emplace(s.distance[mesh_.from(h)] + s.distance[mesh_.to(h)], h, from_hole);
    };
    const auto push_face = [&](std::int32_t f) {
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) push(h, false);
    };
    std::vector<bool> hole_done(shape_.loops.size(), false);
    cutter_.face_marks.clear();
    cutter_.halfedge_marks.clear();
    cutter_.face_marks.add(faces_[0]);
    push_face(faces_[0]);
    while (!queue.empty()) {
      const auto [length, h, from_hole] = queue.top();
      queue.pop();
      if (leads_out(h, from_hole)) {
        const std::int32_t hole = loop_of_edge.at(h);
        if (hole_done[hole]) continue;
        hole_done[hole] = true;
        cutter_.halfedge_marks.add(h);
        for (const std::int32_t g : shape_.loops[hole]) push(g, true);
        continue;
      }
      const std::int32_t face = face_behind(h, from_hole);
      if (!cutter_.face_marks.add(face)) continue;
      cutter_.halfedge_marks.add(h);
      if (!from_hole) cutter_.halfedge_marks.add(mesh_.opposite(h));
      push_face(face);
    }
  }

  [[nodiscard]] std::vector<std::int32_t> path_to_root(std::int32_t v) const {
    std::vector<std::int32_t> path;
    for (; v != kNone; v = cutter_.vertices.via[v]) path.push_back(v);
    return path;
  }

  /// The loop that edge h closes over the tree.
  [[nodiscard]] HandleLoop loop_of(std::int32_t h) const {
    std::vector<std::int32_t> a = path_to_root(mesh_.from(h)), b = path_to_root(mesh_.to(h));
    while (a.size() > 1 && b.size() > 1 && a[a.size() - 2] == b[b.size() - 2]) {
      a.pop_back();
      b.pop_back();
    }
    HandleLoop loop;
    loop.length = edge_length(a.front(), b.front());
    for (const auto* path : {&a, &b})
      for (std::size_t i = 1; i < path->size(); ++i) loop.length += edge_length((*path)[i - 1], (*path)[i]);
    loop.vertices = std::move(a);
    loop.vertices.insert(loop.vertices.end(), b.begin(), b.end() - 1);
    return loop;
  }

  Cutter& cutter_;
  const Mesh& mesh_;
  const std::int32_t chart_;
  std::span<const std::int32_t> faces_;
  const Shape& shape_;
};

/// The faces of the chart that touch the loop.
std::vector<std::int32_t> strip_along(Cutter& cutter, std::int32_t chart, const HandleLoop& loop) {
  std::vector<std::int32_t> strip;
  cutter.face_marks.clear();
  for (const std::int32_t v : loop.vertices)
    for_each_leaving(cutter.labels.mesh, v, [&](std::int32_t h) {
      if (cutter.labels.label[h / 3] == chart && cutter.face_marks.add(h / 3)) strip.push_back(h / 3);
    });
  return strip;
}

/// Adds to the strip all components of the rest of its chart except the largest.
/// \return the largest component
std::vector<std::int32_t> keep_largest_component(Labels& labels, std::int32_t chart,
                                                 std::span<const std::int32_t> faces,
                                                 std::vector<std::int32_t>& strip) {
  const std::int32_t to = labels.label[strip[0]];
  std::vector<std::vector<std::int32_t>> components;
  labels.face_marks.clear();
  for (const std::int32_t f : faces) {
    if (labels.label[f] != chart || labels.face_marks.has(f)) continue;
    labels.charts.edit(chart).face = f;
    components.push_back(labels.flood(chart));
  }
  const auto largest = std::max_element(components.begin(), components.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (auto c = components.begin(); c != components.end(); ++c) {
    if (c == largest) continue;
    for (const std::int32_t f : *c) labels.label.set(f, to);
    strip.insert(strip.end(), c->begin(), c->end());
  }
  labels.charts.edit(chart).face = largest->front();
  return std::move(*largest);
}

/// Cuts a chart along one loop after another, each away from the cuts before it.
class HandleCutter {
 public:
  HandleCutter(Cutter& cutter, std::int32_t chart, const Shape& shape)
      : cutter_(cutter),
        labels_(cutter.labels),
        chart_(chart),
        genus_(shape.genus),
        faces_(labels_.faces_of(chart)),
        loops_(Trees(cutter, chart, faces_, shape).handle_loops()) {}

  void run(Job& job) {
    int tries = 0;
    cutter_.blocked.clear();
    for (const HandleLoop& loop : loops_) {
      if (genus_ == 0 || tries == kLoopTries) return;
      if (std::any_of(loop.vertices.begin(), loop.vertices.end(), [&](auto v) { return cutter_.blocked.has(v); }))
        continue;
      job.poll();
      if (!cut_along(loop)) ++tries;
    }
  }

 private:
  /// \return whether genus has fallen
  bool cut_along(const HandleLoop& loop) {
    std::vector<std::int32_t> strip = strip_along(cutter_, chart_, loop);
    if (strip.size() >= faces_.size()) return false;
    cutter_.face_marks.clear();
    for (const std::int32_t f : strip) cutter_.face_marks.add(f);
    const auto stays = std::find_if(faces_.begin(), faces_.end(), [&](auto f) { return !cutter_.face_marks.has(f); });
    labels_.part(strip, *stays, Cause::handle);
    std::vector<std::int32_t> rest = keep_largest_component(labels_, chart_, faces_, strip);
    const Shape a = labels_.shape(rest), b = labels_.shape(strip, true);
    if (b.components == 1 && a.genus + b.genus < genus_) {
      genus_ = a.genus;
      faces_ = std::move(rest);
      for (const std::int32_t f : strip)
        for (const std::int32_t v : labels_.mesh.triangles()[f]) cutter_.blocked.add(v);
      return true;
    }
    for (const std::int32_t f : strip) labels_.label.set(f, chart_);
    labels_.charts.pop_back();
    labels_.touched.resize(labels_.touched.size() - 2);
    return false;
  }

  Cutter& cutter_;
  Labels& labels_;
  const std::int32_t chart_;
  std::int32_t genus_;
  std::vector<std::int32_t> faces_;      // faces of the rest of the chart
  const std::vector<HandleLoop> loops_;  // the shortest first
};

}  // namespace

std::int32_t cut_handles(Cutter& cutter, std::int32_t chart, const Shape& shape, Job& job) {
  const std::int32_t before = cutter.labels.chart_count();
  HandleCutter(cutter, chart, shape).run(job);
  return cutter.labels.chart_count() - before;
}

}  // namespace isimp::meshing
