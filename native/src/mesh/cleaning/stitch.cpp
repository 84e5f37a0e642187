#include "cleaning/stitch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "isimp/core/forest.h"
#include "isimp/core/to_integer.h"
#include "isimp/mesh/hash_grid.h"
#include "isimp/mesh/mesh.h"
#include "surface/parallel_loops.h"

namespace isimp::detail {
namespace {

// tuned real
constexpr double kEdges = 2.0;        // mean edges: the distance where none is given
constexpr double kNearShare = 0.1;    // least share of the border near another component, if no distance is given
constexpr double kLeastJoined = 100;  // vertices that go to another component then: fewer are no chunks of a scan
constexpr double kNearEnd = 0.35;     // share of an edge: a vertex nearer to its end is merged with the end
constexpr double kFacing = 0.5;       // cosine of the angle between faces that are joined
constexpr std::int32_t kApart = 12;   // places along a border from which it counts as another one

/// The target of a border vertex.
struct Hit {
  std::int32_t vertex, edge;  // the latter by its place among the border's half-edges
  double along;               // place on the edge, from 0 to 1
  bool joins_components;
};

class Stitcher {
 public:
  Stitcher(const MeshArrays& arrays, const Topology& topology, Job& job)
      : arrays_(arrays),
        topology_(topology),
        job_(job),
        loop_(arrays.vertices.size(), kNone),
        place_(arrays.vertices.size(), 0),
        component_(arrays.vertices.size()) {
    for (const Triangle& t : arrays.triangles) {
      component_.join(t[0], t[1]);
      component_.join(t[0], t[2]);
    }
    for (const std::int32_t first : topology.border) {
      if (loop_[from(first)] != kNone) continue;
      const auto loop = static_cast<std::int32_t>(loop_size_.size());
      std::int32_t h = first, place = 0;
      do {
        loop_[from(h)] = loop;
        place_[from(h)] = place++;
        h = topology.vertex_halfedge[to(h)];
      } while (h != first);
      loop_size_.push_back(place);
    }
  }

  /// The places of all border vertices that have another border within a distance.
  std::vector<Hit> find(double distance) {
    distance_ = distance;
    const HashGrid edges = registered_edges();
    std::vector<Hit> hits;
    for (const std::int32_t h : topology_.border)
      if (const auto hit = nearest(edges, h)) hits.push_back(*hit);
    return hits;
  }

  [[nodiscard]] Stitched join(const std::vector<Hit>& hits, RepairLog& log) {
    Forest same(arrays_.vertices.size());
    std::map<std::int32_t, std::vector<std::pair<double, std::int32_t>>> put;  // by face and edge
    for (const Hit& hit : hits) {
      const std::int32_t h = topology_.border[hit.edge];
      log.add(RepairKind::stitched_vertices,
              arrays_.source_vertex.empty() ? hit.vertex : arrays_.source_vertex[hit.vertex]);
      if (hit.along < kNearEnd) {
        same.join(hit.vertex, from(h));
      } else if (hit.along > 1 - kNearEnd) {
        same.join(hit.vertex, to(h));
      } else {
        put[h].emplace_back(hit.along, hit.vertex);
      }
    }
    Stitched result;
    result.vertices = arrays_.vertices;
    result.distance = distance_;
    const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t source) {
      const Triangle t{same.root(a), same.root(b), same.root(c)};
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
      result.triangles.push_back(t);
      result.source_face.push_back(source);
    };
    auto divided = put.begin();
    for (std::int32_t f = 0; f < static_cast<std::int32_t>(arrays_.triangles.size()); ++f) {
      if (divided == put.end() || divided->first / 3 != f) {
        const auto& [a, b, c] = arrays_.triangles[f];
        add(a, b, c, f);
        continue;
      }
      auto& [h, points] = *divided;
      std::sort(points.begin(), points.end());
      std::int32_t last = from(h);
      for (const auto& [along, v] : points) add(std::exchange(last, v), v, apex(h), f);
      add(last, to(h), apex(h), f);
      // The next pass divides the other border edges of this face.
      while (divided != put.end() && divided->first / 3 == f) ++divided;
    }
    return result;
  }

 private:
  [[nodiscard]] std::int32_t from(std::int32_t h) const { return arrays_.triangles[h / 3][h % 3]; }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return arrays_.triangles[h / 3][(h + 1) % 3]; }
  [[nodiscard]] std::int32_t apex(std::int32_t h) const { return arrays_.triangles[h / 3][(h + 2) % 3]; }
  [[nodiscard]] const Vec3& at(std::int32_t v) const { return arrays_.vertices[v]; }
  [[nodiscard]] Vec3 normal(std::int32_t h) const {
    const Vec3 n = (at(to(h)) - at(from(h))).cross(at(apex(h)) - at(from(h)));
    return n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero());
  }
  /// Away from the face of a border edge, in its plane.
  [[nodiscard]] Vec3 outward(std::int32_t h) const { return (at(to(h)) - at(from(h))).cross(normal(h)); }

  void poll_at_times() {
    if (steps_++ % kPollEvery == 0) job_.poll();
  }

  /// The border edges by points along them, at most the width of a cell apart: an edge within the distance of a vertex
  /// has a point within twice that. A cell is no smaller than a mean edge, so that few points do for any distance.
  [[nodiscard]] HashGrid registered_edges() {
    double sum = 0;
    for (const std::int32_t h : topology_.border) sum += (at(to(h)) - at(from(h))).norm();
    const auto count = static_cast<double>(topology_.border.size());
    const double cell = std::max(2 * distance_, sum / count);
    HashGrid edges(2 * topology_.border.size(), cell);
    for (std::size_t i = 0; i < topology_.border.size(); ++i) {
      const Vec3 &a = at(from(topology_.border[i])), &b = at(to(topology_.border[i]));
      const std::int32_t steps = 1 + to_integer((b - a).norm() / cell, 0, std::numeric_limits<std::int32_t>::max() - 1);
      for (std::int32_t k = 0; k < steps; ++k) {
        poll_at_times();
        edges.keep(a + (k + 0.5) / steps * (b - a), static_cast<std::int32_t>(i));
      }
    }
    return edges;
  }

  /// \param h  the half-edge of the border that leaves the vertex
  [[nodiscard]] std::optional<Hit> nearest(const HashGrid& edges, std::int32_t h) {
    const std::int32_t v = from(h);
    const Vec3 n = normal(h), out = outward(h).normalized();
    std::optional<Hit> best;
    double least = distance_;
    edges.for_each_near(at(v), [&](std::int32_t edge) {
      poll_at_times();
      const std::int32_t g = topology_.border[edge];
      if (from(g) == v || to(g) == v || is_near_along(v, g)) return;
      const Vec3 a = at(from(g)), d = at(to(g)) - a;
      const double square = d.squaredNorm();
      const double t = square > 0 ? std::clamp((at(v) - a).dot(d) / square, 0.0, 1.0) : 0.0;
      const Vec3 way = a + t * d - at(v);
      const double far = way.norm();
      const bool better = far < least || (far == least && best && edge < best->edge);
      if (!better || std::abs(n.dot(normal(g))) < kFacing) return;
      const bool joins = component_.root(v) != component_.root(from(g));
      // On one component a strip of faces may lie between two borders, which is no gap.
      if (!joins && !(way.dot(out) > 0 && way.dot(outward(g)) < 0)) return;
      least = far;
      best = Hit{v, edge, t, joins};
    });
    return best;
  }

  [[nodiscard]] bool is_near_along(std::int32_t v, std::int32_t g) const {
    if (loop_[v] != loop_[from(g)]) return false;
    const std::int32_t steps = std::abs(place_[v] - place_[from(g)]);
    return std::min(steps, loop_size_[loop_[v]] - steps) <= kApart;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  Job& job_;
  std::vector<std::int32_t> loop_, place_;  // by vertex, of the border
  std::vector<std::int32_t> loop_size_;
  Forest component_;  // components of vertices
  double distance_ = 0;
  std::uint32_t steps_ = 0;  // of the search, for polls
};

double mean_edge(const MeshArrays& arrays) {
  double area = 0;
  for (const auto& [a, b, c] : arrays.triangles) {
    const Vec3 &p = arrays.vertices[a], &q = arrays.vertices[b], &r = arrays.vertices[c];
    area += (q - p).cross(r - p).norm() / 2;
  }
  return std::sqrt(4 / std::sqrt(3.0) * area / static_cast<double>(arrays.triangles.size()));
}

}  // namespace

std::optional<Stitched> stitch(const MeshArrays& arrays, const Topology& topology, std::optional<double> distance,
                               RepairLog& log, Job& job) {
  if (topology.border.empty() || distance == 0.0) return std::nullopt;
  // Triangles of which most edges are borders are a soup to be welded, not chunks.
  if (!distance && topology.border.size() >= arrays.triangles.size()) return std::nullopt;
  const double reach = distance ? *distance : kEdges * mean_edge(arrays);
  if (!(reach > 0)) return std::nullopt;
  Stitcher stitcher(arrays, topology, job);
  const std::vector<Hit> hits = stitcher.find(reach);
  const auto joining = std::count_if(hits.begin(), hits.end(), [](const Hit& h) { return h.joins_components; });
  const double least =
      distance ? 1.0 : std::max(kLeastJoined, kNearShare * static_cast<double>(topology.border.size()));
  if (hits.empty() || static_cast<double>(distance ? hits.size() : joining) < least) return std::nullopt;
  Stitched result = stitcher.join(hits, log);
  return result.triangles.empty() ? std::nullopt : std::optional(std::move(result));
}

}  // namespace isimp::detail
