#include "cleaning/stitch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "isimp/core/forest.h"
#include "isimp/core/to_integer.h"
#include "isimp/mesh/mesh.h"

namespace isimp::detail {
namespace {

constexpr double kEdges = 2.0;     // mean edges: the distance where none is given
constexpr double kShare = 0.1;     // least share of the border near another component, if no distance is given
constexpr double kLeast = 100;     // vertices that go to another component then: fewer are no chunks of a scan
constexpr double kNearEnd = 0.35;  // share of an edge: a vertex nearer to its end is merged with the end
constexpr double kFacing = 0.5;    // cosine of the angle between faces that are joined
constexpr double kCell = 1.3;      // times the distance: size of the cells of the search for edges
constexpr std::int64_t kFarthest = std::int64_t{1} << 52;  // cell along an axis
constexpr std::int32_t kApart = 12;                        // places along a border from which it counts as another one

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
    register_edges();
    std::vector<Hit> hits;
    for (std::size_t i = 0; i < topology_.border.size(); ++i) {
      if (i % 1024 == 0) job_.poll();
      if (const auto hit = nearest(topology_.border[i])) hits.push_back(*hit);
    }
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
  using Key = std::uint64_t;
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

  [[nodiscard]] Key key(const Vec3& cell) const {
    Key hash = 0;
    for (int k = 0; k < 3; ++k) {
      hash = (hash ^ static_cast<Key>(to_integer(cell[k], -kFarthest, kFarthest))) * 0x9e3779b97f4a7c15ULL;
      hash ^= hash >> 32;
    }
    return hash;
  }
  [[nodiscard]] Vec3 cell(const Vec3& p) const { return (p / (kCell * distance_)).array().floor(); }

  /// Each border edge in the cells of points along it, at most half the distance apart.
  void register_edges() {
    cells_.clear();
    for (std::size_t i = 0; i < topology_.border.size(); ++i) {
      const Vec3 &a = at(from(topology_.border[i])), &b = at(to(topology_.border[i]));
      const int steps = 1 + to_integer((b - a).norm() / (distance_ / 2), 0, 10000);
      Key last = 0;
      for (int k = 0; k < steps; ++k) {
        const Key here = key(cell(a + (k + 0.5) / steps * (b - a)));
        if (k == 0 || here != last) cells_.emplace_back(here, static_cast<std::int32_t>(i));
        last = here;
      }
    }
    std::sort(cells_.begin(), cells_.end());
  }

  /// \param h  the half-edge of the border that leaves the vertex
  [[nodiscard]] std::optional<Hit> nearest(std::int32_t h) const {
    const std::int32_t v = from(h);
    const Vec3 home = cell(at(v)), n = normal(h), out = outward(h).normalized();
    std::optional<Hit> best;
    double least = distance_;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const Key here = key(home + Vec3(i, j, k));
          for (auto e = std::lower_bound(cells_.begin(), cells_.end(), std::pair{here, std::int32_t{0}});
               e != cells_.end() && e->first == here; ++e) {
            const std::int32_t g = topology_.border[e->second];
            if (from(g) == v || to(g) == v || is_near_along(v, g)) continue;
            const Vec3 a = at(from(g)), d = at(to(g)) - a;
            const double square = d.squaredNorm();
            const double t = square > 0 ? std::clamp((at(v) - a).dot(d) / square, 0.0, 1.0) : 0.0;
            const Vec3 way = a + t * d - at(v);
            const double far = way.norm();
            const bool better = far < least || (far == least && best && e->second < best->edge);
            if (!better || std::abs(n.dot(normal(g))) < kFacing) continue;
            const bool joins = component_.root(v) != component_.root(from(g));
            // On one component a strip of faces may lie between two borders, which is no gap.
            if (!joins && !(way.dot(out) > 0 && way.dot(outward(g)) < 0)) continue;
            least = far;
            best = Hit{v, e->second, t, joins};
          }
        }
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
  mutable Forest component_;  // components of vertices
  double distance_ = 0;
  std::vector<std::pair<Key, std::int32_t>> cells_;  // sorted
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
  const double least = distance ? 1.0 : std::max(kLeast, kShare * static_cast<double>(topology.border.size()));
  if (hits.empty() || static_cast<double>(distance ? hits.size() : joining) < least) return std::nullopt;
  Stitched result = stitcher.join(hits, log);
  return result.triangles.empty() ? std::nullopt : std::optional(std::move(result));
}

}  // namespace isimp::detail
