#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "close.h"
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
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(distance_.size()); ++v)
      if (distance_[v] == kFar && topology_.vertex_halfedge[v] != kNone) grow(v, kFar);
    std::vector<Loop> loops;
    for (const std::int32_t h : left_over()) {
      for (const std::int32_t v : reached_) distance_[v] = kFar;
      reached_.clear();
      grow(from(h), longest / 2);
      for (const std::int32_t g : left_over())
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

  /// The edges in neither tree, a half-edge each. Edges that the first tree does not reach are all crossed by the
  /// other.
  [[nodiscard]] std::vector<std::int32_t> left_over() const {
    struct Edge {
      double length;
      std::int32_t h;
    };
    std::vector<Edge> edges;
    // Faces, then one node for each border loop, by its least half-edge.
    std::vector<std::int32_t> up(arrays_.triangles.size());
    std::iota(up.begin(), up.end(), 0);
    std::unordered_map<std::int32_t, std::int32_t> hole;
    for (const std::int32_t h : topology_.border) {
      if (hole.count(h)) continue;
      const auto node = static_cast<std::int32_t>(up.size());
      up.push_back(node);
      for (std::int32_t g = h; hole.emplace(g, node).second;) g = topology_.vertex_halfedge[to(g)];
    }
    const auto root = [&](std::int32_t i) {
      while (up[i] != i) i = up[i] = up[up[i]];
      return i;
    };
    const auto join = [&](std::int32_t h) {
      const std::int32_t other = topology_.opposite[h];
      const std::int32_t a = root(h / 3), b = root(other == kNone ? hole.at(h) : other / 3);
      up[std::max(a, b)] = std::min(a, b);
      return a != b;
    };
    for_each_index(topology_.opposite.size(), job_, [&](std::size_t i) {
      const auto h = static_cast<std::int32_t>(i);
      const std::int32_t a = from(h), b = to(h), other = topology_.opposite[h];
      if (other != kNone && other < h) return;
      if (distance_[a] == kFar || distance_[b] == kFar)
        join(h);
      else if (via_[a] != b && via_[b] != a)
        edges.push_back({distance_[a] + distance_[b] + distance(a, b), h});
    });
    std::sort(edges.begin(), edges.end(),
              [](const Edge& x, const Edge& y) { return std::tie(y.length, x.h) < std::tie(x.length, y.h); });
    std::vector<std::int32_t> left;
    for (const Edge& e : edges)
      if (!join(e.h)) left.push_back(e.h);
    return left;
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
    for (std::size_t i = 0; i < loop.vertices.size(); ++i)
      loop.length += distance(loop.vertices[i], loop.vertices[(i + 1) % loop.vertices.size()]);
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
      : arrays_(arrays), topology_(topology), taken_(arrays.vertices.size(), 0), gone_(arrays.triangles.size(), 0) {}

  /// \return no loops if the faces round the loop are no ring, reach a border of the mesh or one taken before
  Opening take(const Loop& loop) {
    Opening o;
    o.kind = RepairKind::cut_handles;
    for (const std::int32_t v : loop.vertices) add_fan(v, o.removed);
    std::sort(o.removed.begin(), o.removed.end());
    o.removed.erase(std::unique(o.removed.begin(), o.removed.end()), o.removed.end());
    if (!free_inside(o.removed) || !find_borders(o, loop) || parts_surface(o)) return {};
    for (const std::int32_t f : o.removed)
      for (const std::int32_t v : arrays_.triangles[f]) taken_[v] = 1;
    return o;
  }

 private:
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
  /// gone.
  [[nodiscard]] bool parts_surface(const Opening& o) {
    for (const std::int32_t f : o.removed) gone_[f] = 1;
    std::vector<char> seen = gone_;
    std::vector<std::int32_t> stack;
    const auto visit = [&](std::int32_t h) {
      if (const std::int32_t other = topology_.opposite[h]; other != kNone && !seen[other / 3]) {
        seen[other / 3] = 1;
        stack.push_back(other / 3);
      }
    };
    const auto each_fan = [&](std::size_t border, auto&& call) {
      std::vector<std::int32_t> faces;
      for (const std::int32_t v : o.loops[border]) add_fan(v, faces);
      for (const std::int32_t f : faces)
        if (!gone_[f]) call(f);
    };
    each_fan(0, [&](std::int32_t f) {
      if (!std::exchange(seen[f], 1)) stack.push_back(f);
    });
    while (!stack.empty()) {
      const std::int32_t f = stack.back();
      stack.pop_back();
      for (std::int32_t k = 0; k < 3; ++k) visit(3 * f + k);
    }
    bool joined = false;
    each_fan(1, [&](std::int32_t f) { joined |= seen[f] != 0; });
    if (!joined)
      for (const std::int32_t f : o.removed) gone_[f] = 0;
    return !joined;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  std::vector<char> taken_;  // vertices of rings taken before
  std::vector<char> gone_;   // their faces
};

}  // namespace

std::vector<Opening> find_handles(const MeshArrays& arrays, const Topology& topology, double longest, Job& job) {
  std::vector<Opening> handles;
  Rings rings(arrays, topology);
  for (const Loop& loop : HandleLoops(arrays, topology, job).find(longest))
    if (Opening o = rings.take(loop); !o.loops.empty()) handles.push_back(std::move(o));
  return handles;
}

}  // namespace isimp::detail
