#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "close.h"
#include "isimp/core/forest.h"
#include "isimp/mesh/mesh.h"

/// A tree over the vertices by distance, and a tree over faces and holes that crosses none of its edges and takes those
/// first whose loops are long: each edge left over closes a loop over the first tree that does not part the surface,
/// two a handle. Grown from anywhere they tell where handles are; grown again from there, how short the loops are.
/// Source: Erickson and Whittlesey 2005.
namespace isimp::detail {
namespace {

struct Loop {
  double length = 0;
  std::vector<std::int32_t> vertices;
};

class HandleLoops {
 public:
  HandleLoops(const MeshArrays& arrays, const Topology& topology, Job& job)
      : arrays_(arrays),
        topology_(topology),
        job_(job),
        distance_(arrays.vertices.size(), kFar),
        via_(arrays.vertices.size(), kNone) {}

  /// Those of at most `longest`, shortest first.
  std::vector<Loop> find(double longest) {
    const Dual all = all_edges();
    if (!any_handle(all)) return {};
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(distance_.size()); ++v)
      if (distance_[v] == kFar && topology_.vertex_halfedge[v] != kNone) grow(v, kFar);
    const std::vector<std::int32_t> starts = left_over(all);
    const Dual dual = near_edges(all, starts, longest / 2);
    std::vector<Loop> loops;
    for (const std::int32_t h : starts) {
      forget();
      grow(from(h), longest / 2);
      for (const std::int32_t g : left_over(dual))
        if (Loop loop = loop_of(g); loop.length <= longest) loops.push_back(std::move(loop));
    }
    std::stable_sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) { return a.length < b.length; });
    return loops;
  }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();

  [[nodiscard]] std::int32_t from(std::int32_t h) const { return arrays_.triangles[h / 3][h % 3]; }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return from(Mesh::next(h)); }
  [[nodiscard]] double distance(std::int32_t a, std::int32_t b) const {
    return (arrays_.vertices[a] - arrays_.vertices[b]).norm();
  }

  void grow(std::int32_t root, double radius) {
    using Entry = std::pair<double, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto reach = [&](std::int32_t v, double d, std::int32_t via) {
      if (d > radius || d >= distance_[v]) return;
      if (distance_[v] == kFar) reached_.push_back(v);
      distance_[v] = d;
      via_[v] = via;
      queue.emplace(d, v);
    };
    reach(root, 0, kNone);
    for (std::size_t taken = 1; !queue.empty(); ++taken) {
      if (taken % kPollEvery == 0) job_.poll();
      const auto [d, v] = queue.top();
      queue.pop();
      if (d > distance_[v]) continue;
      std::int32_t h = topology_.vertex_halfedge[v];
      const std::int32_t start = h;
      do {
        reach(to(h), d + distance(v, to(h)), v);
        const std::int32_t in = Mesh::prev(h);
        reach(from(in), d + distance(v, from(in)), v);
        h = topology_.opposite[in];
      } while (h != kNone && h != start);
    }
  }

  /// Edges, a half-edge each, rising, and the nodes on both sides of each: faces and holes, or what is one for all
  /// that will be asked.
  struct Dual {
    std::vector<std::int32_t> edges;
    std::vector<std::array<std::int32_t, 2>> sides;
    std::size_t nodes = 0;
  };

  /// All edges between faces, then one node for each border loop.
  [[nodiscard]] Dual all_edges() const {
    Dual dual;
    dual.nodes = arrays_.triangles.size();
    std::unordered_map<std::int32_t, std::int32_t> hole;
    for (const std::int32_t h : topology_.border) {
      if (hole.count(h)) continue;
      const auto node = static_cast<std::int32_t>(dual.nodes++);
      for (std::int32_t g = h; hole.emplace(g, node).second;) g = topology_.vertex_halfedge[to(g)];
    }
    for_each_index(topology_.opposite.size(), job_, [&](std::size_t i) {
      const auto h = static_cast<std::int32_t>(i);
      const std::int32_t other = topology_.opposite[h];
      if (other != kNone && other < h) return;
      dual.edges.push_back(h);
      dual.sides.push_back({h / 3, other == kNone ? hole.at(h) : other / 3});
    });
    return dual;
  }

  /// By Euler's formula, holes counted as faces.
  [[nodiscard]] bool any_handle(const Dual& all) const {
    Forest forest(all.nodes);
    std::size_t joins = 0;
    for (const auto& sides : all.sides) joins += forest.join(sides[0], sides[1]) ? 1 : 0;
    const std::size_t used = topology_.vertex_halfedge.size() - static_cast<std::size_t>(topology_.unused_vertices);
    // Over all components, used - edges + nodes = 2 (nodes - joins) without a handle.
    return used + 2 * joins != all.edges.size() + all.nodes;
  }

  /// The edges near some half-edges. All others are crossed wherever the first tree grows from one of these, so what
  /// they join is one node.
  [[nodiscard]] Dual near_edges(const Dual& all, const std::vector<std::int32_t>& starts, double radius) {
    std::vector<char> near(distance_.size(), 0);
    for (const std::int32_t h : starts) {
      forget();
      grow(from(h), radius);
      for (const std::int32_t v : reached_) near[v] = 1;
    }
    Forest far(all.nodes);
    Dual dual;
    for (std::size_t i = 0; i < all.edges.size(); ++i) {
      const std::int32_t h = all.edges[i];
      if (near[from(h)] && near[to(h)]) {
        dual.edges.push_back(h);
        dual.sides.push_back(all.sides[i]);
      } else {
        far.join(all.sides[i][0], all.sides[i][1]);
      }
    }
    std::unordered_map<std::int32_t, std::int32_t> number;
    for (auto& sides : dual.sides)
      for (std::int32_t& node : sides)
        node = number.emplace(far.root(node), static_cast<std::int32_t>(number.size())).first->second;
    dual.nodes = number.size();
    return dual;
  }

  /// The edges in neither tree, a half-edge each. Edges that the first tree does not reach are all crossed by the
  /// other.
  [[nodiscard]] std::vector<std::int32_t> left_over(const Dual& dual) const {
    struct Edge {
      double length;
      std::int32_t h, i;
    };
    std::vector<Edge> edges;
    Forest forest(dual.nodes);
    const auto join = [&](std::size_t i) { return forest.join(dual.sides[i][0], dual.sides[i][1]); };
    for_each_index(dual.edges.size(), job_, [&](std::size_t i) {
      const std::int32_t h = dual.edges[i], a = from(h), b = to(h);
      if (distance_[a] == kFar || distance_[b] == kFar)
        join(i);
      else if (via_[a] != b && via_[b] != a)
        edges.push_back({distance_[a] + distance_[b] + distance(a, b), h, static_cast<std::int32_t>(i)});
    });
    std::sort(edges.begin(), edges.end(),
              [](const Edge& x, const Edge& y) { return std::tie(y.length, x.h) < std::tie(x.length, y.h); });
    std::vector<std::int32_t> left;
    for (const Edge& e : edges)
      if (!join(e.i)) left.push_back(e.h);
    return left;
  }

  /// Leaves nothing reached.
  void forget() {
    for (const std::int32_t v : reached_) distance_[v] = kFar;
    reached_.clear();
  }

  /// The loop that an edge closes over the tree, without the path that leads there.
  [[nodiscard]] Loop loop_of(std::int32_t h) const {
    std::vector<std::int32_t> a, b;
    for (std::int32_t v = from(h); v != kNone; v = via_[v]) a.push_back(v);
    for (std::int32_t v = to(h); v != kNone; v = via_[v]) b.push_back(v);
    while (a.size() > 1 && b.size() > 1 && a[a.size() - 2] == b[b.size() - 2]) {
      a.pop_back();
      b.pop_back();
    }
    Loop loop;
    loop.vertices = std::move(a);
    loop.vertices.insert(loop.vertices.end(), b.rbegin() + 1, b.rend());
    loop.length = length(arrays_, loop.vertices);
    return loop;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  Job& job_;
  std::vector<double> distance_;
  std::vector<std::int32_t> via_, reached_;
};

/// The faces that touch a loop, if they are a ring with two borders and the surface does not fall apart without them
/// and all that was taken before.
class Rings {
 public:
  Rings(const MeshArrays& arrays, const Topology& topology)
      : arrays_(arrays),
        topology_(topology),
        taken_(arrays.vertices.size(), 0),
        gone_(arrays.triangles.size(), 0),
        seen_(arrays.triangles.size(), 0) {}

  /// \return no loops if the faces round the loop are no ring, reach a border of the mesh or one taken before
  Opening take(const Loop& loop) { return take(ring_of(loop)); }

  /// The same, but only where one of the places means it. It counts as gone for those that are taken after it, so that
  /// no other loop closes what stays: neither one that crosses it nor one in the same tunnel.
  Opening hold(const Loop& loop, const std::vector<Vec3>& keep) {
    Opening o = ring_of(loop);
    return o.loops.empty() || !is_kept(arrays_, o, keep) ? Opening{} : take(std::move(o));
  }

 private:
  static constexpr int kMostRows = 32;
  static constexpr double kWider = 1.3;  // times the loop's length: a border beyond is no longer in the tunnel

  [[nodiscard]] Opening ring_of(const Loop& loop) const {
    Opening o;
    o.kind = RepairKind::cut_handles;
    o.length = loop.length;
    add_fans(loop.vertices, o.removed);
    if (!free_inside(o.removed) || !find_borders(o, loop)) return {};
    for (int rows = 0; rows < kMostRows && widen(o, loop);) ++rows;
    return o;
  }

  Opening take(Opening o) {
    if (o.loops.empty() || parts_surface(o)) return {};
    for (const std::int32_t f : o.removed)
      for (const std::int32_t v : arrays_.triangles[f]) taken_[v] = 1;
    return o;
  }

  /// Takes the ring's next faces on both sides, as far as they are in the same tunnel or on the same handle: were it cut
  /// in the middle alone, a dent would stay on both sides.
  /// \return whether there were any
  bool widen(Opening& o, const Loop& loop) const {
    bool any = false;
    for (int side = 0; side < 2; ++side) {
      Opening wider;
      wider.kind = o.kind;
      wider.length = o.length;
      wider.removed = o.removed;
      add_fans(o.loops[side], wider.removed);
      if (!free_inside(wider.removed) || !find_borders(wider, loop)) continue;
      const auto is_narrow = [&](const std::vector<std::int32_t>& border) {
        return length(arrays_, border) <= kWider * loop.length;
      };
      // The border that did not move may be wide already.
      const bool narrow = std::all_of(wider.loops.begin(), wider.loops.end(), [&](const auto& border) {
        return is_narrow(border) || is_same(border, o.loops[1 - side]);
      });
      if (!narrow) continue;
      o = std::move(wider);
      any = true;
    }
    return any;
  }

  static bool is_same(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
    return a.size() == b.size() && std::find(b.begin(), b.end(), a[0]) != b.end();
  }

  /// The faces round some vertices are added to rising ones.
  void add_fans(const std::vector<std::int32_t>& vertices, std::vector<std::int32_t>& faces) const {
    for (const std::int32_t v : vertices) add_fan(v, faces);
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  }

  void add_fan(std::int32_t v, std::vector<std::int32_t>& faces) const {
    const std::int32_t start = topology_.vertex_halfedge[v];
    std::int32_t h = start;
    do {
      faces.push_back(h / 3);
      h = topology_.opposite[Mesh::prev(h)];
    } while (h != kNone && h != start);
  }

  [[nodiscard]] bool free_inside(const std::vector<std::int32_t>& faces) const {
    return std::all_of(faces.begin(), faces.end(), [&](std::int32_t f) {
      for (int k = 0; k < 3; ++k)
        if (taken_[arrays_.triangles[f][k]] || topology_.opposite[3 * f + k] == kNone) return false;
      return true;
    });
  }

  /// The loops round the removed faces, each vertex once in all: two of them.
  [[nodiscard]] bool find_borders(Opening& o, const Loop& loop) const {
    std::unordered_map<std::int32_t, std::int32_t> next;
    std::vector<std::int32_t> starts;
    for (const std::int32_t f : o.removed)
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        if (std::binary_search(o.removed.begin(), o.removed.end(), topology_.opposite[h] / 3)) continue;
        const std::int32_t a = arrays_.triangles[f][h % 3], b = arrays_.triangles[f][(h + 1) % 3];
        if (!next.emplace(a, b).second) return false;  // the border touches itself
        starts.push_back(a);
      }
    for (const std::int32_t v : loop.vertices)
      if (next.count(v)) return false;  // the loop would stay in part
    for (const std::int32_t start : starts) {
      const auto first = next.find(start);
      if (first == next.end()) continue;
      std::vector<std::int32_t> border;
      for (auto at = first; at != next.end(); at = next.find(border.back())) {
        border.push_back(at->second);
        next.erase(at);
      }
      o.loops.push_back(std::move(border));
    }
    return o.loops.size() == 2;
  }

  /// Whether no way leads from one border of the ring to the other any more; if there is one, the ring's faces are
  /// gone. Searches from both, so that a handle costs what its faces are, and not the whole surface.
  [[nodiscard]] bool parts_surface(const Opening& o) {
    for (const std::int32_t f : o.removed) gone_[f] = 1;
    std::array<std::vector<std::int32_t>, 2> front;
    rings_ += 2;
    bool joined = false;
    const auto visit = [&](std::int32_t f, int side) {
      if (gone_[f] || seen_[f] == rings_ + side) return;
      joined |= seen_[f] == rings_ + 1 - side;
      seen_[f] = rings_ + side;
      front[side].push_back(f);
    };
    for (int side = 0; side < 2; ++side) {
      std::vector<std::int32_t> faces;
      add_fans(o.loops[side], faces);
      for (const std::int32_t f : faces) visit(f, side);
    }
    while (!joined && !front[0].empty() && !front[1].empty())
      for (int side = 0; side < 2; ++side)
        for (const std::int32_t f : std::exchange(front[side], {}))
          for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
            if (const std::int32_t other = topology_.opposite[h]; other != kNone) visit(other / 3, side);
    if (!joined)
      for (const std::int32_t f : o.removed) gone_[f] = 0;
    return !joined;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  std::vector<char> taken_;         // vertices of rings taken before
  std::vector<char> gone_;          // their faces
  std::vector<std::int32_t> seen_;  // by face: the last ring, and its border, from which it was reached
  std::int32_t rings_ = 0;
};

}  // namespace

Handles find_handles(const MeshArrays& arrays, const Topology& topology, double longest, const std::vector<Vec3>& keep,
                     Job& job) {
  Handles handles;
  Rings rings(arrays, topology);
  const std::vector<Loop> loops = HandleLoops(arrays, topology, job).find(longest);
  for (const Loop& loop : loops) {
    if (keep.empty()) break;
    if (Opening o = rings.hold(loop, keep); !o.loops.empty()) handles.kept.push_back(std::move(o));
  }
  for (const Loop& loop : loops)
    if (Opening o = rings.take(loop); !o.loops.empty()) handles.closed.push_back(std::move(o));
  return handles;
}

}  // namespace isimp::detail
