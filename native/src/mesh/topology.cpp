#include "topology.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "edge_groups.h"
#include "isimp/mesh/mesh.h"
#include "pieces.h"

namespace isimp::detail {
namespace {

constexpr std::uint32_t kMany = 24;  // entries of a bucket from which it is sorted and searched by halves

std::string edge_name(std::int32_t a, std::int32_t b) {
  return "the edge of vertices " + std::to_string(std::min(a, b)) + " and " + std::to_string(std::max(a, b));
}

/// The half-edges that run from a smaller to a larger vertex, by the smaller one. In a sound mesh every other half-edge
/// finds its opposite among the few of its larger end's bucket.
class RisingHalfedges {
 public:
  RisingHalfedges(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) : end_(vertex_count + 1, 0) {
    for_each_index(triangles.size(), job, [&](std::size_t f) {
      const auto& [a, b, c] = triangles[f];
      end_[a] += a < b;
      end_[b] += b < c;
      end_[c] += c < a;
    });
    std::uint32_t sum = 0;
    for (std::uint32_t& end : end_) sum += std::exchange(end, sum);  // now where each bucket begins
    entries_ = std::make_unique_for_overwrite<Entry[]>(sum);
    for_each_index(triangles.size(), job, [&](std::size_t f) {
      const auto& [a, b, c] = triangles[f];
      const auto h = static_cast<std::int32_t>(3 * f);
      if (a < b) entries_[end_[a]++] = {b, h};
      if (b < c) entries_[end_[b]++] = {c, h + 1};
      if (c < a) entries_[end_[c]++] = {a, h + 2};
    });
    for_each_index(vertex_count, job, [&](std::size_t v) { tidy(begin(v), end_[v]); });
  }

  /// Whether two half-edges run the same way.
  [[nodiscard]] bool has_twins() const { return has_twins_; }
  /// The half-edge from one vertex to a larger one, or kNone.
  [[nodiscard]] std::int32_t find(std::int32_t from, std::int32_t to) const {
    const std::uint32_t last = end_[from];
    std::uint32_t i = begin(static_cast<std::size_t>(from));
    if (last - i > kMany) {
      const Entry* at =
          std::lower_bound(&entries_[i], &entries_[last], to, [](const Entry& e, std::int32_t v) { return e.to < v; });
      return at != &entries_[last] && at->to == to ? at->half_edge : kNone;
    }
    while (i < last && entries_[i].to != to) ++i;
    return i < last ? entries_[i].half_edge : kNone;
  }

 private:
  struct Entry {
    std::int32_t to, half_edge;
  };
  [[nodiscard]] std::uint32_t begin(std::size_t v) const { return v == 0 ? 0 : end_[v - 1]; }
  /// Sorts a long bucket, and looks for twins.
  void tidy(std::uint32_t first, std::uint32_t last) {
    if (last - first > kMany) {
      std::sort(&entries_[first], &entries_[last], [](const Entry& a, const Entry& b) { return a.to < b.to; });
      for (std::uint32_t i = first + 1; i < last; ++i) has_twins_ |= entries_[i].to == entries_[i - 1].to;
      return;
    }
    for (std::uint32_t i = first; i < last; ++i)
      for (std::uint32_t j = i + 1; j < last; ++j) has_twins_ |= entries_[i].to == entries_[j].to;
  }

  std::vector<std::uint32_t> end_;  // of each vertex's bucket
  std::unique_ptr<Entry[]> entries_;
  bool has_twins_ = false;
};

/// Pairs all half-edges; false if an edge has three or more faces, or two that run the same way.
bool pair_halfedges(Topology& topology, std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) {
  const RisingHalfedges rising(vertex_count, triangles, job);
  if (rising.has_twins()) return false;
  job.report(0.3);
  std::vector<std::int32_t>& opposite = topology.opposite;
  opposite.assign(3 * triangles.size(), kNone);
  std::vector<std::pair<std::int32_t, std::int32_t>> alone;  // the falling half-edges on a border, turned round
  bool sound = true;
  const auto pair = [&](std::int32_t from, std::int32_t to, std::int32_t h) {
    if (from < to) return;
    const std::int32_t other = rising.find(to, from);
    if (other == kNone) {
      alone.emplace_back(to, from);
      return;
    }
    sound &= opposite[other] == kNone;
    opposite[other] = h;
    opposite[h] = other;
  };
  for_each_index(triangles.size(), job, [&](std::size_t f) {
    const auto& [a, b, c] = triangles[f];
    const auto h = static_cast<std::int32_t>(3 * f);
    pair(a, b, h);
    pair(b, c, h + 1);
    pair(c, a, h + 2);
  });
  std::sort(alone.begin(), alone.end());
  return sound && std::adjacent_find(alone.begin(), alone.end()) == alone.end();
}

/// Names the first edge that is not sound.
std::string describe_bad_edge(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) {
  std::string what;
  const auto from = [&](std::int32_t h) { return triangles[h / 3][h % 3]; };
  EdgeGroups(vertex_count, triangles, job).for_each(job, [&](const EdgeGroup& edge) {
    if (!what.empty() || edge.size() < 2) return;
    const std::string name = edge_name(from(edge[0]), from(Mesh::next(edge[0])));
    if (edge.size() > 2) {
      what = name + " has three or more faces, face " + std::to_string(edge[2] / 3) + " among them";
    } else if (from(edge[0]) == from(edge[1])) {
      what = "faces " + std::to_string(edge[0] / 3) + " and " + std::to_string(edge[1] / 3) +
             " run the same way along " + name;
    }
  });
  return what;
}

/// The number of faces that turning round a vertex meets.
std::int64_t walk(const std::vector<std::int32_t>& opposite, std::int32_t start) {
  std::int64_t met = 0;
  std::int32_t h = start;
  do {
    ++met;
    h = opposite[Mesh::prev(h)];
  } while (h != kNone && h != start);
  return met;
}

std::string describe_bad_vertex(const Topology& topology, std::span<const Triangle> triangles) {
  std::vector<std::int64_t> faces(topology.vertex_halfedge.size(), 0);
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) ++faces[v];
  std::size_t v = 0;
  while (faces[v] == 0 || faces[v] == walk(topology.opposite, topology.vertex_halfedge[v])) ++v;
  return "the faces of vertex " + std::to_string(v) + " form two or more fans";
}

/// Finds a half-edge that leaves each vertex; false if the faces of some vertex are not one fan.
bool find_fans(Topology& topology, std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) {
  std::vector<std::int32_t>& leaving = topology.vertex_halfedge;
  leaving.assign(vertex_count, kNone);
  for_each_index(triangles.size(), job, [&](std::size_t f) {
    for (std::size_t k = 0; k < 3; ++k) leaving[triangles[f][k]] = static_cast<std::int32_t>(3 * f + k);
  });
  for_each_index(topology.opposite.size(), job, [&](std::size_t h) {
    if (topology.opposite[h] != kNone) return;
    topology.border.push_back(static_cast<std::int32_t>(h));
    leaving[triangles[h / 3][h % 3]] = static_cast<std::int32_t>(h);  // from there the walk meets all faces
  });
  std::int64_t met = 0;  // no walk meets more than its vertex's faces, so that the sum tells whether one met fewer
  for_each_index(vertex_count, job, [&](std::size_t v) {
    if (leaving[v] == kNone) {
      ++topology.unused_vertices;
    } else {
      met += walk(topology.opposite, leaving[v]);
    }
  });
  return met == static_cast<std::int64_t>(topology.opposite.size());
}

}  // namespace

Topology find_topology(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) {
  Topology topology;
  if (!pair_halfedges(topology, vertex_count, triangles, job)) {
    topology.flaw = describe_bad_edge(vertex_count, triangles, job);
    return topology;
  }
  job.report(0.7);
  if (!find_fans(topology, vertex_count, triangles, job)) {
    topology.flaw = describe_bad_vertex(topology, triangles);
  }
  return topology;
}

}  // namespace isimp::detail
