#include "cleaning/handle_places.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "cleaning/close.h"
#include "isimp/core/forest.h"
#include "isimp/mesh/mesh.h"

/// The surface is parted into discs of some faces. Junctions, where more than two of them meet, and the chains of edges between
/// junctions make a complex of the same topology with a fortieth of the edges. A tree over the junctions, and one over
/// discs and holes that crosses none of its chains and takes those first whose loops are long, leave two chains a handle.
/// Source: Erickson and Whittlesey 2005.
namespace isimp::detail {
namespace {

constexpr std::int32_t kFacesOfDisc = 64;  // work

/// A border of two discs, or of a disc and a hole, from one junction to the next.
struct Chain {
  std::int32_t from, to;     // junctions
  std::int32_t left, right;  // nodes: discs, and then holes
  double length;
};

class Complex {
 public:
  Complex(const MeshArrays& arrays, const Topology& topology, Job& job)
      : arrays_(arrays), topology_(topology), job_(job), node_(arrays.triangles.size(), kNone) {
    grow_discs();
    find_chains();
  }

  /// Adds a vertex for each chain that no tree holds if the first tree grows from the first junction of each component,
  /// or from the last one.
  void add_left_over(bool from_last, std::vector<std::int32_t>& vertices) const {
    const auto [distance, via] = shortest_paths(from_last);
    std::vector<std::pair<double, std::int32_t>> closing;  // length of the loop, chain
    for (std::int32_t i = 0; i < std::ssize(chains_); ++i)
      if (const Chain& c = chains_[i]; via[c.from] != i && via[c.to] != i)
        closing.emplace_back(distance[c.from] + c.length + distance[c.to], i);
    std::sort(closing.begin(), closing.end(),
              [](const auto& a, const auto& b) { return std::tie(b.first, a.second) < std::tie(a.first, b.second); });
    Forest forest(nodes_);
    for (const auto& [length, i] : closing)
      if (!forest.join(chains_[i].left, chains_[i].right)) vertices.push_back(vertex_[chains_[i].from]);
  }

 private:
  [[nodiscard]] std::int32_t from(std::int32_t h) const { return arrays_.triangles[h / 3][h % 3]; }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return from(Mesh::next(h)); }

  /// Grows the discs, breadth first. A face joins over one edge if its third vertex is not in the disc, or over two.
  void grow_discs() {
    std::vector<std::int32_t> disc_of(arrays_.vertices.size(), kNone), faces;
    const auto joins = [&](std::int32_t h) {  // the face at h, which is across an edge of the disc
      const std::int32_t third = from(Mesh::prev(h));
      int shared = 0;
      for (const std::int32_t g : {h, Mesh::next(h), Mesh::prev(h)})
        if (const std::int32_t other = topology_.opposite[g]; other != kNone) shared += node_[other / 3] == nodes_;
      return shared == 2 || (shared == 1 && disc_of[third] != nodes_);
    };
    const auto add = [&](std::int32_t f) {
      node_[f] = nodes_;
      for (const std::int32_t v : arrays_.triangles[f]) disc_of[v] = nodes_;
      faces.push_back(f);
    };
    for_each_index(node_.size(), job_, [&](std::size_t first) {
      if (node_[first] != kNone) return;
      faces.clear();
      add(static_cast<std::int32_t>(first));
      for (std::size_t i = 0; i < faces.size() && faces.size() < kFacesOfDisc; ++i)
        for (std::int32_t h = 3 * faces[i]; h < 3 * faces[i] + 3 && faces.size() < kFacesOfDisc; ++h)
          if (const std::int32_t other = topology_.opposite[h];
              other != kNone && node_[other / 3] == kNone && joins(other))
            add(other / 3);
      ++nodes_;
    });
  }

  void find_chains() {
    std::unordered_map<std::int32_t, std::int32_t> hole;  // by border half-edge
    for (const std::int32_t h : topology_.border)
      if (!hole.contains(h)) {
        for (std::int32_t g = h; hole.emplace(g, nodes_).second;) g = topology_.vertex_halfedge[to(g)];
        ++nodes_;
      }
    const auto across = [&](std::int32_t h) {
      const std::int32_t other = topology_.opposite[h];
      return other == kNone ? hole.at(h) : node_[other / 3];
    };
    constexpr std::uint8_t kMany = 3;                              // mark
    std::vector<std::uint8_t> degree(arrays_.vertices.size(), 0);  // border edges at a vertex, up to kMany
    std::vector<std::int32_t> border;                              // half-edges, one of each edge
    for_each_index(topology_.opposite.size(), job_, [&](std::size_t i) {
      const auto h = static_cast<std::int32_t>(i);
      const std::int32_t other = topology_.opposite[h];
      if (other != kNone && node_[other / 3] == node_[h / 3]) return;
      border.push_back(h);
      if (other != kNone && other < h) return;
      for (const std::int32_t v : {from(h), to(h)}) degree[v] = std::min<std::uint8_t>(degree[v] + 1, kMany);
    });
    std::vector<std::int32_t> junction(arrays_.vertices.size(), kNone);
    const auto junction_at = [&](std::int32_t v) {
      if (junction[v] == kNone) {
        junction[v] = static_cast<std::int32_t>(vertex_.size());
        vertex_.push_back(v);
      }
      return junction[v];
    };
    for (const std::int32_t h : border) {
      const std::int32_t left = node_[h / 3], right = across(h);
      if (degree[from(h)] == 2 || left > right) continue;  // on a chain, or seen from the other side
      double length = 0;
      std::int32_t g = h;
      while (true) {
        length += (arrays_.vertices[from(g)] - arrays_.vertices[to(g)]).norm();
        if (degree[to(g)] != 2) break;
        for (g = Mesh::next(g); across(g) == left;) g = Mesh::next(topology_.opposite[g]);
      }
      chains_.push_back({junction_at(from(h)), junction_at(to(g)), left, right, length});
    }
  }

  struct Paths {
    std::vector<double> distance;   // by junction
    std::vector<std::int32_t> via;  // by junction: the chain that the path ends with; kNone at a root
  };
  [[nodiscard]] Paths shortest_paths(bool from_last) const {
    const auto count = static_cast<std::int32_t>(vertex_.size());
    std::vector<std::int32_t> first(count + 1, 0), at(2 * chains_.size());  // chains by junction
    for (const Chain& c : chains_)
      for (const std::int32_t j : {c.from, c.to}) ++first[j + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::int32_t> fill(first.begin(), first.end() - 1);
    for (std::int32_t i = 0; i < std::ssize(chains_); ++i)
      for (const std::int32_t j : {chains_[i].from, chains_[i].to}) at[fill[j]++] = i;
    Paths paths{std::vector<double>(count, std::numeric_limits<double>::infinity()),
                std::vector<std::int32_t>(count, kNone)};
    using Reached = std::pair<double, std::int32_t>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
    const auto reach = [&](std::int32_t j, double distance, std::int32_t chain) {
      if (distance >= paths.distance[j]) return;
      paths.distance[j] = distance;
      paths.via[j] = chain;
      queue.emplace(distance, j);
    };
    for (std::int32_t i = 0; i < count; ++i) {
      const std::int32_t root = from_last ? count - 1 - i : i;
      if (paths.distance[root] < std::numeric_limits<double>::infinity()) continue;
      job_.poll();
      for (reach(root, 0, kNone); !queue.empty();) {
        const auto [distance, j] = queue.top();
        queue.pop();
        if (distance > paths.distance[j]) continue;
        for (const std::int32_t c : std::span(at).subspan(first[j], first[j + 1] - first[j]))
          reach(chains_[c].from == j ? chains_[c].to : chains_[c].from, distance + chains_[c].length, c);
      }
    }
    return paths;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  Job& job_;
  std::vector<std::int32_t> node_;    // by face: its disc
  std::int32_t nodes_ = 0;            // discs and holes
  std::vector<std::int32_t> vertex_;  // by junction
  std::vector<Chain> chains_;
};

}  // namespace

std::vector<std::int32_t> places_of_handles(const MeshArrays& arrays, const Topology& topology, Job& job) {
  const Complex complex(arrays, topology, job);
  std::vector<std::int32_t> vertices;
  // One tree may lead far past a handle, so there are two.
  for (const bool from_last : {false, true}) complex.add_left_over(from_last, vertices);
  return rising(std::move(vertices));
}

}  // namespace isimp::detail
