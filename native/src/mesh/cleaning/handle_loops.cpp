#include "cleaning/handle_loops.h"

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "isimp/core/forest.h"
#include "isimp/core/prefetch.h"
#include "isimp/core/to_integer.h"
#include "isimp/core/undo_forest.h"
#include "isimp/mesh/mesh.h"

/// A tree over the vertices by distance, and a tree over faces and holes that crosses none of its edges and takes those
/// first whose loops are long: each edge left over closes a loop over the first tree that does not part the surface,
/// two a handle. Trees from any start show the places of handles. Trees from these places show the lengths of loops.
/// Source: Erickson and Whittlesey 2005.
namespace isimp::detail {
namespace {

class HandleLoops {
 public:
  HandleLoops(const MeshArrays& arrays, const Topology& topology, Job& job)
      : arrays_(arrays),
        topology_(topology),
        job_(job),
        distance_(arrays.vertices.size(), kFar),
        via_(arrays.vertices.size(), kNone),
        edge_(arrays.vertices.size(), kNone) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t f = 0; f < arrays.triangles.size(); f += kSample, ++count)
      sum += distance(arrays.triangles[f][0], arrays.triangles[f][1]);
    per_length_ = sum > 0 ? static_cast<double>(count) / sum : 1;
    number_holes();
  }

  /// By Euler's formula, holes counted as faces. Without a handle, used - edges + nodes is 2 for each component.
  [[nodiscard]] bool any_handle() const {
    const std::size_t used = topology_.vertex_halfedge.size() - static_cast<std::size_t>(topology_.unused_vertices);
    const std::size_t edges = (topology_.opposite.size() + topology_.border.size()) / 2;
    if (used + nodes_ < edges + 2) return true;  // whatever the number of components
    Forest forest(nodes_);
    std::size_t joins = 0;
    for_each_edge([&](std::int32_t h) { joins += forest.join(h / 3, across(h)) ? 1 : 0; });
    return used + 2 * joins != edges + nodes_;
  }

  /// Vertices at handles, two a handle.
  /// \param last  whether to grow from the last vertex of each component in place of the first
  std::vector<std::int32_t> find_starts(bool last) {
    const auto count = static_cast<std::int32_t>(distance_.size());
    for (std::int32_t i = 0; i < count; ++i) {
      const std::int32_t v = last ? count - 1 - i : i;
      if (distance_[v] == kFar && topology_.vertex_halfedge[v] != kNone) grow({&v, 1}, kFar);
    }
    std::vector<std::int32_t> starts = left_over(core());
    for (std::int32_t& h : starts) h = from(h);
    return starts;
  }

  /// Edges, a half-edge each, rising, and the nodes on both sides of each. A node is a face, a hole, or a set of
  /// them that is joined for all later queries.
  struct Dual {
    std::vector<std::int32_t> edges;
    std::vector<std::array<std::int32_t, 2>> sides;
    std::size_t nodes = 0;
  };

  /// The edges near some vertices. A first tree that grows from one of these vertices, up to the radius, has no other
  /// edge. So the faces that the other edges join are one node.
  [[nodiscard]] Dual near_edges(const std::vector<std::int32_t>& starts, double radius) {
    forget();
    grow(starts, radius);
    const auto is_near = [&](std::int32_t v) { return distance_[v] != kFar; };
    Forest far(nodes_);
    Dual dual;
    for_each_edge([&](std::int32_t h) {
      if (is_near(from(h)) && is_near(to(h))) {
        dual.edges.push_back(h);
        dual.sides.push_back({h / 3, across(h)});
      } else {
        far.join(h / 3, across(h));
      }
    });
    std::unordered_map<std::int32_t, std::int32_t> number;
    for (auto& sides : dual.sides)
      for (std::int32_t& node : sides)
        node = number.emplace(far.root(node), static_cast<std::int32_t>(number.size())).first->second;
    dual.nodes = number.size();
    return dual;
  }

  /// Loops of at most `longest` near each of some vertices.
  /// \param dual  near these at least, within half of that
  std::vector<HandleLoop> find(std::span<const std::int32_t> starts, const Dual& dual, double longest) {
    std::vector<HandleLoop> loops;
    const EdgesAt at = edges_by_vertex(dual);
    const std::size_t most = kMostReached * (dual.edges.size() + starts.size());
    for (std::size_t begin = 0; begin < starts.size();) {
      std::vector<Reached> some;
      for (std::size_t sum = 0; begin < starts.size() && sum < most; ++begin) {
        some.push_back(reached_from(starts[begin], longest / 2, at, dual));
        sum += some.back().edges.size();
      }
      Halving halving{dual, longest, UndoForest(dual.nodes), std::vector<std::int32_t>(dual.edges.size(), 0), 1};
      halving.mark(some);
      for (std::size_t i = 0; i < dual.edges.size(); ++i) halving.join_unmarked(static_cast<std::int32_t>(i));
      halve(some, halving, loops);
    }
    return loops;
  }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();  // mark
  // tuned repairs
  static constexpr std::size_t kAhead = 8;    // work: vertices ahead of the current one whose neighbours are prefetched
  static constexpr std::size_t kSample = 16;  // work: faces from one edge that is measured to the next
  static constexpr std::size_t kMostReached = 4;  // work: starts are halved in one group while their trees together
                                                  // have fewer than this many times (edges + starts) edges
  static constexpr std::size_t kMostBuckets = 1U << 16;  // work: the last one has all that is farther

  [[nodiscard]] std::int32_t from(std::int32_t h) const { return arrays_.triangles[h / 3][h % 3]; }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return from(Mesh::next(h)); }
  [[nodiscard]] double distance(std::int32_t a, std::int32_t b) const {
    return (arrays_.vertices[a] - arrays_.vertices[b]).norm();
  }

  /// Grows one tree from some vertices, so that each vertex hangs on the nearest of them: by buckets of distances, which
  /// are taken in order; inside one, vertices are taken again where a shorter way comes.
  void grow(std::span<const std::int32_t> roots, double radius) {
    std::size_t last = 0;
    const auto reach = [&](std::int32_t v, double d, std::int32_t via, std::int32_t edge) {
      if (d > radius || d >= distance_[v]) return;
      if (distance_[v] == kFar) reached_.push_back(v);
      distance_[v] = d;
      via_[v] = via;
      edge_[v] = edge;
      const std::size_t at = bucket_of(d);
      if (at >= buckets_.size()) buckets_.resize(at + 1);
      buckets_[at].push_back(v);
      last = std::max(last, at);
    };
    for (const std::int32_t root : roots) reach(root, 0, kNone, kNone);
    std::size_t taken = 0;
    for (std::size_t now = 0; now <= last; ++now) {
      for (std::size_t i = 0; i < buckets_[now].size(); ++i) {
        if (++taken % kPollEvery == 0) job_.poll();
        const std::int32_t v = buckets_[now][i];
        if (i + kAhead < buckets_[now].size()) prefetch(&topology_.vertex_halfedge[buckets_[now][i + kAhead]]);
        if (i + kAhead / 2 < buckets_[now].size()) {
          const std::int32_t h = topology_.vertex_halfedge[buckets_[now][i + kAhead / 2]];
          prefetch(&arrays_.triangles[h / 3]);
          prefetch(&topology_.opposite[h]);
        }
        const double d = distance_[v];
        if (bucket_of(d) < now) continue;
        std::int32_t h = topology_.vertex_halfedge[v];
        const std::int32_t start = h;
        do {
          reach(to(h), d + distance(v, to(h)), v, h);
          const std::int32_t in = Mesh::prev(h);
          if (topology_.opposite[in] == kNone) reach(from(in), d + distance(v, from(in)), v, in);
          h = topology_.opposite[in];
        } while (h != kNone && h != start);
      }
      buckets_[now].clear();
    }
  }
  [[nodiscard]] std::size_t bucket_of(double d) const {
    return to_integer(d * per_length_, std::size_t{0}, kMostBuckets);
  }

  /// One node for each border loop, after the nodes of the faces.
  void number_holes() {
    nodes_ = arrays_.triangles.size();
    for (const std::int32_t h : topology_.border) {
      if (hole_.count(h)) continue;
      const auto node = static_cast<std::int32_t>(nodes_++);
      for (std::int32_t g = h; hole_.emplace(g, node).second;) g = topology_.vertex_halfedge[to(g)];
    }
  }

  /// The node across a half-edge.
  [[nodiscard]] std::int32_t across(std::int32_t h) const {
    const std::int32_t other = topology_.opposite[h];
    return other == kNone ? hole_.at(h) : other / 3;
  }

  /// Calls fn(h) for one half-edge of each edge, in rising order.
  template <class Function>
  void for_each_edge(Function fn) const {
    for_each_index(topology_.opposite.size(), job_, [&](std::size_t i) {
      const auto h = static_cast<std::int32_t>(i);
      const std::int32_t other = topology_.opposite[h];
      if (other == kNone || other > h) fn(h);
    });
  }

  /// Whether an edge is in the tree over the vertices.
  [[nodiscard]] bool in_tree(std::int32_t h) const {
    const std::int32_t other = topology_.opposite[h], a = edge_[from(h)], b = edge_[to(h)];
    return a == h || b == h || (other != kNone && (a == other || b == other));
  }

  /// The edges that the tree over all vertices does not hold, without edges that any tree over the faces has to cross:
  /// a face with one such edge left is removed, repeatedly. Few edges are left, at handles and between holes.
  [[nodiscard]] Dual core() const {
    std::vector<std::uint8_t> open(arrays_.triangles.size(), 7);  // a bit for each such edge of a face
    for_each_index(edge_.size(), job_, [&](std::size_t v) {
      for (std::int32_t h = edge_[v], side = 0; h != kNone && side < 2; h = topology_.opposite[h], ++side)
        open[h / 3] &= ~(1 << h % 3);
    });
    std::vector<std::int32_t> ends;
    for_each_index(open.size(), job_, [&](std::size_t i) {
      if (std::has_single_bit(open[i])) ends.push_back(static_cast<std::int32_t>(i));
    });
    while (!ends.empty()) {
      const std::int32_t f = ends.back();
      ends.pop_back();
      if (!std::has_single_bit(open[f])) continue;  // its last edge was removed with the other face
      const std::int32_t other = topology_.opposite[3 * f + std::countr_zero(open[f])];
      if (other == kNone) continue;
      open[f] = 0;
      open[other / 3] &= ~(1 << other % 3);
      if (std::has_single_bit(open[other / 3])) ends.push_back(other / 3);
    }
    Dual dual;
    dual.nodes = nodes_;
    for_each_index(open.size(), job_, [&](std::size_t i) {
      const auto f = static_cast<std::int32_t>(i);
      for (int k = 0; open[i] != 0 && k < 3; ++k) {
        const std::int32_t h = 3 * f + k, other = topology_.opposite[h];
        if ((open[i] >> k & 1) == 0 || (other != kNone && other < h)) continue;
        dual.edges.push_back(h);
        dual.sides.push_back({f, across(h)});
      }
    });
    return dual;
  }

  /// A vertex of a tree that grew from a start.
  struct Grown {
    double distance;
    std::int32_t vertex, via, edge;
  };
  /// The tree of a start, and the edges of the dual with both ends in its reach, by number.
  struct Reached {
    std::vector<Grown> tree;
    std::vector<std::int32_t> edges;
  };

  /// The edges of a dual, by number, in the order of the vertices that they begin at.
  struct EdgesAt {
    std::vector<std::int32_t> first, edges;  // first: by vertex, and one more
    [[nodiscard]] std::span<const std::int32_t> of(std::int32_t v) const {
      return std::span(edges).subspan(first[v], first[v + 1] - first[v]);
    }
  };

  [[nodiscard]] EdgesAt edges_by_vertex(const Dual& dual) const {
    EdgesAt at{std::vector<std::int32_t>(distance_.size() + 1, 0), std::vector<std::int32_t>(dual.edges.size())};
    for (const std::int32_t h : dual.edges) ++at.first[from(h) + 1];
    std::partial_sum(at.first.begin(), at.first.end(), at.first.begin());
    std::vector<std::int32_t> fill(at.first.begin(), at.first.end() - 1);
    for (std::size_t i = 0; i < dual.edges.size(); ++i)
      at.edges[fill[from(dual.edges[i])]++] = static_cast<std::int32_t>(i);
    return at;
  }

  Reached reached_from(std::int32_t start, double radius, const EdgesAt& at, const Dual& dual) {
    forget();
    grow({&start, 1}, radius);
    Reached r;
    r.tree.reserve(reached_.size());
    for (const std::int32_t v : reached_) {
      r.tree.push_back({distance_[v], v, via_[v], edge_[v]});
      for (const std::int32_t i : at.of(v))
        if (distance_[to(dual.edges[i])] != kFar) r.edges.push_back(i);
    }
    std::sort(r.edges.begin(), r.edges.end());
    return r;
  }

  /// The state of a search that halves the starts: edges that no current start reaches are joined.
  struct Halving {
    const Dual& dual;
    double longest;
    UndoForest forest;
    std::vector<std::int32_t> seen;  // by edge: the last round in which it was marked
    std::int32_t round;

    bool join(std::int32_t i) { return forest.join(dual.sides[i][0], dual.sides[i][1]); }
    void mark(std::span<const Reached> some) {
      for (const Reached& r : some)
        for (const std::int32_t i : r.edges) seen[i] = round;
    }
    void join_unmarked(std::int32_t i) {
      if (std::exchange(seen[i], round) != round) join(i);
    }
  };

  /// Finds the loops of some starts. Before one half of them, the edges that only the other half reaches are joined, and
  /// these joins are undone after it. So an edge is joined about log2(starts) times for each start that reaches it.
  void halve(std::span<const Reached> some, Halving& h, std::vector<HandleLoop>& loops) {
    if (some.size() == 1) return find_at(some[0], h, loops);
    const auto first = some.first(some.size() / 2), second = some.subspan(some.size() / 2);
    const auto enter = [&](std::span<const Reached> half, std::span<const Reached> other) {
      const std::size_t joins = h.forest.joins();
      ++h.round;
      h.mark(half);
      for (const Reached& r : other)
        for (const std::int32_t i : r.edges) h.join_unmarked(i);
      halve(half, h, loops);
      h.forest.undo(joins);
    };
    enter(first, second);
    enter(second, first);
  }

  /// Adds the loops of one start. All edges that it does not reach are joined.
  void find_at(const Reached& reached, Halving& h, std::vector<HandleLoop>& loops) {
    forget();
    for (const auto& [distance, vertex, via, edge] : reached.tree) {
      distance_[vertex] = distance;
      via_[vertex] = via;
      edge_[vertex] = edge;
      reached_.push_back(vertex);
    }
    std::vector<Edge> edges;
    for (const std::int32_t i : reached.edges)
      if (!in_tree(h.dual.edges[i])) edges.push_back(edge_of(i, h.dual));
    sort_longest_first(edges);
    const std::size_t joins = h.forest.joins();
    for (const Edge& e : edges) {
      if (h.join(e.i)) continue;
      if (HandleLoop loop = loop_of(e.h); loop.length <= h.longest) loops.push_back(std::move(loop));
    }
    h.forest.undo(joins);
  }

  /// An edge of the dual and the length of its loop, as far as the place where its paths to the start meet.
  struct Edge {
    double length;
    std::int32_t h, i;
  };
  [[nodiscard]] Edge edge_of(std::int32_t i, const Dual& dual) const {
    const std::int32_t h = dual.edges[i], a = from(h), b = to(h);
    return {distance_[a] + distance_[b] + distance(a, b), h, i};
  }
  static void sort_longest_first(std::vector<Edge>& edges) {
    std::sort(edges.begin(), edges.end(),
              [](const Edge& x, const Edge& y) { return std::tie(y.length, x.h) < std::tie(x.length, y.h); });
  }

  /// The edges in neither tree, a half-edge each. Edges that the first tree does not reach are all crossed by the
  /// other.
  [[nodiscard]] std::vector<std::int32_t> left_over(const Dual& dual) const {
    std::vector<Edge> edges;
    Forest forest(dual.nodes);
    const auto join = [&](std::size_t i) { return forest.join(dual.sides[i][0], dual.sides[i][1]); };
    for_each_index(dual.edges.size(), job_, [&](std::size_t i) {
      const std::int32_t h = dual.edges[i], a = from(h), b = to(h);
      if (distance_[a] == kFar || distance_[b] == kFar)
        join(i);
      else if (!in_tree(h))
        edges.push_back(edge_of(static_cast<std::int32_t>(i), dual));
    });
    sort_longest_first(edges);
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
  [[nodiscard]] HandleLoop loop_of(std::int32_t h) const {
    std::vector<std::int32_t> a, b;
    for (std::int32_t v = from(h); v != kNone; v = via_[v]) a.push_back(v);
    for (std::int32_t v = to(h); v != kNone; v = via_[v]) b.push_back(v);
    while (a.size() > 1 && b.size() > 1 && a[a.size() - 2] == b[b.size() - 2]) {
      a.pop_back();
      b.pop_back();
    }
    HandleLoop loop;
    loop.vertices = std::move(a);
    loop.vertices.insert(loop.vertices.end(), b.rbegin() + 1, b.rend());
    loop.length = length(arrays_, loop.vertices);
    return loop;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  Job& job_;
  std::vector<double> distance_;
  std::vector<std::int32_t> via_, edge_, reached_;       // edge_: a half-edge of that to via_, either side
  std::vector<std::vector<std::int32_t>> buckets_;       // vertices by distance, empty but while the tree grows
  double per_length_ = 1;                                // buckets, 1 / scene units
  std::unordered_map<std::int32_t, std::int32_t> hole_;  // node of each border half-edge
  std::size_t nodes_ = 0;                                // faces and holes
};

}  // namespace

std::vector<HandleLoop> find_loops(const MeshArrays& arrays, const Topology& topology, double longest,
                                   const HandleSearch* search, const Threads& threads, Job& job) {
  HandleLoops finder(arrays, topology, job);
  if (!search && !finder.any_handle()) return {};
  HandleLoops other(arrays, topology, job);
  // Two at a time.
  const auto by_both = [&](auto fn) {
    threads.blocks(2, 1, [&](std::int32_t k, std::int32_t, std::int32_t) { fn(k == 0 ? finder : other, k); });
  };
  std::vector<std::int32_t> starts;
  if (search) {
    starts = search->near;
  } else {  // One tree may lead far past a handle, so there are two.
    std::array<std::vector<std::int32_t>, 2> found;
    by_both([&](HandleLoops& each, std::int32_t k) { found[k] = each.find_starts(k == 1); });
    found[0].insert(found[0].end(), found[1].begin(), found[1].end());
    starts = rising(std::move(found[0]));
  }
  if (starts.empty()) return {};
  const HandleLoops::Dual dual = finder.near_edges(starts, longest / 2);
  std::array<std::vector<HandleLoop>, 2> loops;
  const std::size_t half = starts.size() / 2;
  by_both([&](HandleLoops& each, std::int32_t k) {
    const std::span all(starts);
    loops[k] = each.find(k == 0 ? all.first(half) : all.subspan(half), dual, longest);
  });
  std::move(loops[1].begin(), loops[1].end(), std::back_inserter(loops[0]));
  std::ranges::stable_sort(loops[0], {}, &HandleLoop::length);
  return std::move(loops[0]);
}

}  // namespace isimp::detail
