// Cuts a chart along chains of shortest paths between its holes.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "discs/discs.h"

namespace isimp::meshing {
namespace {

// tuned holes
constexpr double kTurn = 0.1;        ///< a sharp turn costs as much as a straight link of 1 / kTurn times the length
constexpr double kAgain = 4;         ///< factor on the cost of a link to a loop that has been reached
constexpr double kAgainOfFew = 1e6;  ///< mark: such a factor where loops are few: one chain is to reach all of them
constexpr std::size_t kFew = 8;      ///< most loops that are few
constexpr std::size_t kRow = 12;     ///< holes of a row that one polygon may lie at
constexpr std::int32_t kMostBetweenLoops = 8;  ///< limit: links that are kept between the same two loops

/// The shortest way found between two boundary loops over an edge in the middle.
struct Link {
  std::int32_t from, to;  ///< loops
  std::int32_t halfedge;  ///< in the middle, its ends nearest to `from` and `to`
  double length;
};

/// All boundary loops of a chart grow at once until they meet; where two meet, a link joins them. Ears are chosen among
/// the links: chains from a loop that has been reached, over loops that have not, to one that has.
class Ears {
 public:
  Ears(Cutter& cutter, std::int32_t chart, const Shape& shape)
      : cutter_(cutter),
        mesh_(cutter.labels.mesh),
        chart_(chart),
        shape_(shape),
        reached_(shape.loops.size(), false),
        again_(shape.loops.size() > kFew ? kAgain : kAgainOfFew),
        row_(shape.loops.size(), kNone) {}

  /// Marks the half-edges of all ears.
  /// \return how many ears there are
  std::int32_t find(Job& job) {
    grow(job);
    find_links();
    cutter_.halfedge_marks.clear();
    cutter_.blocked.clear();
    std::int32_t ears = 0;
    reach(shape_.longest_loop(mesh_));
    while (!open_.empty()) {
      const std::int32_t link = -open_.top().second;
      open_.pop();
      if (!reached_[links_[link].to] && is_free(link)) ears += add_ear(link);
    }
    if (cutter_.perforated) part_rows();
    return ears;
  }

 private:
  [[nodiscard]] double edge_length(std::int32_t h) const {
    return (mesh_.vertices()[mesh_.to(h)] - mesh_.vertices()[mesh_.from(h)]).norm();
  }

  /// Shortest paths from all loops. `via` of a vertex is the half-edge that leads to it, `vertex_loop` the loop it
  /// started at.
  void grow(Job& job) {
    Search& search = cutter_.vertices;
    search.start();
    cutter_.vertex_marks.clear();
    for (std::size_t i = 0; i < shape_.loops.size(); ++i)
      for (const std::int32_t h : shape_.loops[i]) {
        const std::int32_t v = mesh_.from(h);
        cutter_.vertex_marks.add(v);
        cutter_.vertex_loop[v] = static_cast<std::int32_t>(i);
        search.reach(v, 0, kNone);
      }
    std::int32_t taken = 0;
    for (std::int32_t v = search.take(); v != kNone; v = search.take()) {
      if (++taken % 4096 == 0) job.poll();
      for_each_leaving(mesh_, v, [&](std::int32_t h) {
        if (cutter_.labels.label[h / 3] != chart_ || !cutter_.labels.inner(h)) return;
        const std::int32_t w = mesh_.to(h);
        if (!cutter_.vertex_marks.has(w) && search.reach(w, search.distance[v] + edge_length(h), h))
          cutter_.vertex_loop[w] = cutter_.vertex_loop[v];
      });
    }
  }

  void find_links() {
    for (const std::int32_t f : cutter_.labels.faces_of(chart_))
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        if (!cutter_.labels.inner(h)) continue;
        const std::int32_t a = cutter_.vertex_loop[mesh_.from(h)], b = cutter_.vertex_loop[mesh_.to(h)];
        if (a == b) continue;
        const Search& s = cutter_.vertices;
        links_.push_back({a, b, h, s.distance[mesh_.from(h)] + edge_length(h) + s.distance[mesh_.to(h)]});
      }
    std::sort(links_.begin(), links_.end(), [](const Link& x, const Link& y) {
      return std::tie(x.from, x.to, x.length, x.halfedge) < std::tie(y.from, y.to, y.length, y.halfedge);
    });
    start_.assign(shape_.loops.size() + 1, 0);
    std::vector<Link> few;
    for (std::size_t i = 0, same = 0; i < links_.size(); ++i) {
      same = i > 0 && links_[i].from == links_[i - 1].from && links_[i].to == links_[i - 1].to ? same + 1 : 0;
      if (same < kMostBetweenLoops) few.push_back(links_[i]);
    }
    links_ = std::move(few);
    for (const Link& l : links_) ++start_[l.from + 1];
    for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  }

  /// Marks a loop as one at which ears may start.
  void reach(std::int32_t loop) {
    reached_[loop] = true;
    for (std::int32_t i = start_[loop]; i < start_[loop + 1]; ++i)
      if (!reached_[links_[i].to]) open_.emplace(-links_[i].length, -i);
  }

  /// Calls fn(vertex, half-edge that leads to it) for the path from a loop to v, from v backwards.
  template <class Function>
  void for_each_back(std::int32_t v, Function fn) const {
    for (std::int32_t h = cutter_.vertices.via[v];; h = cutter_.vertices.via[v]) {
      fn(v, h);
      if (h == kNone) return;
      v = mesh_.from(h);
    }
  }

  /// \param with_ends  whether it may not begin or end where another path does either
  [[nodiscard]] bool is_free(std::int32_t link, bool with_ends = true) const {
    bool free = true;
    for (const std::int32_t v : {mesh_.from(links_[link].halfedge), mesh_.to(links_[link].halfedge)})
      for_each_back(v, [&](std::int32_t w, std::int32_t h) {
        free = free && ((h == kNone && !with_ends) || !cutter_.blocked.has(w));
      });
    return free;
  }

  [[nodiscard]] std::int32_t end_at_loop(std::int32_t v) const {
    for_each_back(v, [&](std::int32_t w, std::int32_t) { v = w; });
    return v;
  }

  [[nodiscard]] Vec3 direction(std::int32_t link) const {
    const std::int32_t h = links_[link].halfedge;
    return (mesh_.vertices()[end_at_loop(mesh_.to(h))] - mesh_.vertices()[end_at_loop(mesh_.from(h))]).normalized();
  }

  void block(std::int32_t link) {
    for (const std::int32_t v : {mesh_.from(links_[link].halfedge), mesh_.to(links_[link].halfedge)})
      for_each_back(v, [&](std::int32_t w, std::int32_t) { cutter_.blocked.add(w); });
  }

  void mark(std::int32_t h) {
    cutter_.halfedge_marks.add(h);
    cutter_.halfedge_marks.add(mesh_.opposite(h));
  }

  /// Continues from a link to an unreached loop, as straight as possible, to a reached one, and adds the ear.
  /// \return 1 if an ear was added, else 0
  std::int32_t add_ear(std::int32_t first) {
    std::vector<std::int32_t> chain{first}, passed;
    block(first);
    while (true) {
      const std::int32_t at = links_[chain.back()].to;
      if (reached_[at]) break;
      if (std::find(passed.begin(), passed.end(), at) != passed.end()) break;
      passed.push_back(at);
      const std::int32_t next = best_from(chain.back(), passed);
      if (next == kNone) return 0;  // the vertices stay blocked, as there is no way on from here
      chain.push_back(next);
      block(next);
    }
    for (const std::int32_t link : chain) mark_path(link);
    for (const std::int32_t loop : passed) {
      reach(loop);
      row_[loop] = static_cast<std::int32_t>(rows_.size());
    }
    rows_.push_back(std::move(passed));
    return 1;
  }

  void mark_path(std::int32_t link) {
    mark(links_[link].halfedge);
    for (const std::int32_t v : {mesh_.from(links_[link].halfedge), mesh_.to(links_[link].halfedge)})
      for_each_back(v, [&](std::int32_t, std::int32_t h) {
        if (h != kNone) mark(h);
      });
  }

  /// Cuts between long rows too, so that no polygon has more corners the more holes there are.
  void part_rows() {
    for (const std::vector<std::int32_t>& row : rows_) {
      const std::size_t parts = (row.size() + kRow - 1) / kRow;
      for (std::size_t k = 1; k < parts; ++k) {
        // The nearest hole at which there is a way across; ways to either side may begin at different ones.
        const std::size_t middle = k * row.size() / parts;
        std::int32_t first = kNone;
        for (std::size_t i = 0; i < kRow; ++i) {
          const std::size_t at = middle + (i % 2 == 0 ? i / 2 : row.size() - (i + 1) / 2);
          const std::int32_t link = shortest_to_earlier_row(row[at % row.size()], first);
          if (link == kNone) continue;
          block(link);
          mark_path(link);
          if (first != kNone) break;
          first = link;
        }
      }
    }
  }

  /// The shortest link from a loop to one of a row before its own, or to the outline, that crosses nothing.
  /// \param other  a link that this one has to lead away from; kNone: no matter
  [[nodiscard]] std::int32_t shortest_to_earlier_row(std::int32_t at, std::int32_t other) const {
    std::int32_t best = kNone;
    for (std::int32_t i = start_[at]; i < start_[at + 1]; ++i) {
      const Link& l = links_[i];
      if (!reached_[l.to] || row_[l.to] >= row_[at] || (best != kNone && l.length >= links_[best].length)) continue;
      if (other != kNone && direction(i).dot(direction(other)) >= 0) continue;
      if (is_free(i, false)) best = i;
    }
    return best;
  }

  [[nodiscard]] std::int32_t best_from(std::int32_t link, std::span<const std::int32_t> passed) const {
    const Vec3 ahead = direction(link);
    const std::int32_t at = links_[link].to;
    std::int32_t best = kNone;
    double least = std::numeric_limits<double>::max();
    for (std::int32_t i = start_[at]; i < start_[at + 1]; ++i) {
      const std::int32_t to = links_[i].to;
      if (std::find(passed.begin(), passed.end(), to) != passed.end()) continue;
      const double straight = (1 + ahead.dot(direction(i))) / 2;
      const double cost = links_[i].length * (reached_[to] ? again_ : 1) / (kTurn + straight * straight);
      if (cost >= least || !is_free(i)) continue;
      least = cost;
      best = i;
    }
    return best;
  }

  Cutter& cutter_;
  const Mesh& mesh_;
  const std::int32_t chart_;
  const Shape& shape_;
  std::vector<bool> reached_;                                  // by loop
  const double again_;                                         // factor on a link to a loop that has been reached
  std::vector<std::int32_t> row_;                              // by loop: its index in rows_, kNone for the outline
  std::vector<std::vector<std::int32_t>> rows_;                // the loops along each ear
  std::vector<Link> links_;                                    // by loop
  std::vector<std::int32_t> start_;                            // where the links of each loop start
  std::priority_queue<std::pair<double, std::int32_t>> open_;  // the shortest link from a loop that was reached first
};

}  // namespace

std::int32_t part_along_marks(Cutter& cutter, std::span<const std::int32_t> faces) {
  Labels& labels = cutter.labels;
  std::vector<std::vector<std::int32_t>> components;
  cutter.face_marks.clear();
  for (const std::int32_t start : faces) {
    if (!cutter.face_marks.add(start)) continue;
    std::vector<std::int32_t>& component = components.emplace_back(1, start);
    for (std::size_t i = 0; i < component.size(); ++i)
      for (std::int32_t h = 3 * component[i], end = h + 3; h < end; ++h)
        if (labels.inner(h) && !cutter.halfedge_marks.has(h) && cutter.face_marks.add(labels.mesh.opposite(h) / 3))
          component.push_back(labels.mesh.opposite(h) / 3);
  }
  for (std::size_t k = 1; k < components.size(); ++k) labels.part(components[k], faces[0], Cause::hole);
  return static_cast<std::int32_t>(components.size()) - 1;
}

std::int32_t cut_holes(Cutter& cutter, std::int32_t chart, const Shape& shape, Job& job) {
  if (Ears(cutter, chart, shape).find(job) == 0) return 0;
  return part_along_marks(cutter, cutter.labels.faces_of(chart));
}

}  // namespace isimp::meshing
