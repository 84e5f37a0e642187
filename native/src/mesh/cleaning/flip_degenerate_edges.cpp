#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "surface/parallel_loops.h"
#include "surface/soup.h"

namespace isimp::detail {
namespace {

constexpr int kFlipRounds = 64;       // limit: a row of flat faces takes one round for each face
constexpr double kThin = 2e-6;        // rounding: height over the diagonal: about the resolution of float32
constexpr double kFlatHeight = 1e-3;  // rounding: height over its longest edge: a face is not flat for being small

/// Flips edges of a manifold mesh and updates its topology.
class EdgeFlipper {
 public:
  EdgeFlipper(MeshArrays& arrays, Topology& topology, RepairLog& log, const Threads& threads, Job& job)
      : p_(arrays),
        t_(topology),
        log_(log),
        thin_(kThin * box_of(arrays.vertices, threads, job, [](std::size_t) { return true; }).diagonal().norm()) {}

  void run(const Threads& threads, Job& job) {
    std::vector<std::int32_t> flat =
        gather<std::int32_t>(threads, p_.triangles.size(), job, [&](std::size_t f, std::vector<std::int32_t>& found) {
          if (is_flat(static_cast<std::int32_t>(f))) found.push_back(static_cast<std::int32_t>(f));
        });
    std::vector<std::pair<double, std::int32_t>> order = by_length(flat);
    if (!order.empty()) touched_.assign(p_.vertices.size(), 0);
    for (round_ = 0; round_ < kFlipRounds && !order.empty(); ++round_) {
      job.poll();
      changed_.clear();
      for (const auto& [length, f] : order)
        if (may_differ(f) && is_flat(f)) flip(longest(f));
      if (changed_.empty()) break;
      update(order);
    }
    if (log_.count(RepairKind::flipped_edges) == 0 || t_.border.empty()) return;
    t_.border.clear();
    for_each_index(t_.opposite.size(), job, [&](std::size_t h) {
      if (t_.opposite[h] == kNone) t_.border.push_back(static_cast<std::int32_t>(h));
    });
  }

 private:
  /// The degenerate ones among some faces, with their longest edges, by falling length.
  [[nodiscard]] std::vector<std::pair<double, std::int32_t>> by_length(const std::vector<std::int32_t>& faces) const {
    std::vector<std::pair<double, std::int32_t>> order;
    for (const std::int32_t f : faces)
      if (is_flat(f)) order.emplace_back(-length(longest(f)), f);
    std::sort(order.begin(), order.end());
    return order;
  }
  /// Inserts the flat ones of the changed faces among the flat faces, in order.
  void update(std::vector<std::pair<double, std::int32_t>>& order) {
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    std::erase_if(
        order, [&](const auto& entry) { return std::binary_search(changed_.begin(), changed_.end(), entry.second); });
    const auto fresh = by_length(changed_), kept = std::move(order);
    order = {};
    std::merge(kept.begin(), kept.end(), fresh.begin(), fresh.end(), std::back_inserter(order));
  }
  /// Whether an edge of this face may be flipped now that could not be flipped in the last round: only a flip at one of
  /// the face's vertices can change that.
  [[nodiscard]] bool may_differ(std::int32_t f) const {
    const Triangle& t = p_.triangles[f];
    return round_ == 0 || std::any_of(t.begin(), t.end(), [&](std::int32_t v) { return touched_[v] >= round_; });
  }

  std::int32_t& from(std::int32_t h) { return p_.triangles[h / 3][h % 3]; }
  [[nodiscard]] const Vec3& at(std::int32_t h) const { return p_.vertices[p_.triangles[h / 3][h % 3]]; }
  [[nodiscard]] double length(std::int32_t h) const { return (at(Mesh::next(h)) - at(h)).norm(); }

  [[nodiscard]] std::int32_t longest(std::int32_t f) const {
    std::int32_t best = 3 * f;
    for (std::int32_t h = 3 * f + 1; h < 3 * f + 3; ++h)
      if (length(h) > length(best)) best = h;
    return best;
  }

  [[nodiscard]] static Vec3 vector_area(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a); }
  [[nodiscard]] Vec3 vector_area(std::int32_t f) const { return vector_area(at(3 * f), at(3 * f + 1), at(3 * f + 2)); }

  [[nodiscard]] double height(std::int32_t f) const {
    const double l = length(longest(f));
    return l > 0 ? vector_area(f).norm() / l : 0;
  }

  /// Whether the face is so thin that its normal is rounding noise.
  [[nodiscard]] bool is_flat(std::int32_t f) const {
    const double twice_area = vector_area(f).norm();
    const double longest_squared =
        std::max({(at(3 * f) - at(3 * f + 1)).squaredNorm(), (at(3 * f + 1) - at(3 * f + 2)).squaredNorm(),
                  (at(3 * f + 2) - at(3 * f)).squaredNorm()});
    return twice_area <= kFlatHeight * longest_squared && twice_area <= thin_ * std::sqrt(longest_squared);
  }

  [[nodiscard]] bool joined(std::int32_t a, std::int32_t b) const {
    const std::int32_t start = t_.vertex_halfedge[a];
    std::int32_t h = start;
    do {
      const Triangle& t = p_.triangles[h / 3];
      if (std::find(t.begin(), t.end(), b) != t.end()) return true;
      h = t_.opposite[Mesh::prev(h)];
    } while (h != kNone && h != start);
    return false;
  }

  /// Replaces edge a b = h of flat face (a, b, c) and its neighbour (b, a, d) by edge c d, if both faces become higher
  /// and keep the orientation of the neighbour, or if both are flat and the new edge is shorter.
  bool flip(std::int32_t h) {
    const std::int32_t o = t_.opposite[h];
    if (o == kNone) return false;
    const std::int32_t c_at = Mesh::prev(h), d_at = Mesh::prev(o);
    const std::int32_t a = from(h), b = from(o), c = from(c_at), d = from(d_at);
    const Vec3 old_area = vector_area(o / 3);
    const double old_height = std::min(height(h / 3), height(o / 3));
    const bool both_flat = is_flat(o / 3);
    const auto& v = p_.vertices;
    const bool shorter = longest(o / 3) == o && (v[d] - v[c]).norm() < length(h);
    if (joined(c, d)) return false;
    const std::int32_t bc = Mesh::next(h), ad = Mesh::next(o);
    const std::int32_t beyond_ca = t_.opposite[c_at], beyond_db = t_.opposite[d_at];
    from(h) = d;  // (a, b, c) becomes (d, b, c)
    from(o) = c;  // (b, a, d) becomes (c, a, d)
    const auto faces_well = [&](std::int32_t f) { return height(f) > old_height && vector_area(f).dot(old_area) > 0; };
    if (!(both_flat && shorter) && (!faces_well(h / 3) || !faces_well(o / 3))) {
      from(h) = a;
      from(o) = b;
      return false;
    }
    join(h, beyond_db);
    join(o, beyond_ca);
    t_.opposite[c_at] = d_at;
    t_.opposite[d_at] = c_at;
    keep_leaving(a, ad);
    keep_leaving(b, bc);
    keep_leaving(c, o);
    keep_leaving(d, h);
    for (const std::int32_t vertex : {a, b, c, d}) touched_[vertex] = static_cast<std::int8_t>(round_ + 1);
    changed_.insert(changed_.end(), {h / 3, o / 3});
    log_.add(RepairKind::flipped_edges, p_.source_face[h / 3]);
    return true;
  }

  void join(std::int32_t h, std::int32_t beyond) {
    t_.opposite[h] = beyond;
    if (beyond != kNone) t_.opposite[beyond] = h;
  }

  /// Sets the half-edge that find_topology would set, given one that leaves the vertex: the one on the border, else the
  /// last.
  void keep_leaving(std::int32_t v, std::int32_t h) {
    const std::int32_t start = h;
    std::int32_t last = h;
    for (std::int32_t back = t_.opposite[h]; back != kNone; back = t_.opposite[h]) {
      h = Mesh::next(back);
      if (h == start) break;
      last = std::max(last, h);
    }
    t_.vertex_halfedge[v] = t_.opposite[h] == kNone ? h : last;
  }

  MeshArrays& p_;
  Topology& t_;
  RepairLog& log_;
  double thin_;
  int round_ = 0;
  std::vector<std::int8_t> touched_;   // (V) last round, from 1, that flipped an edge at each vertex; 0 if none did
  std::vector<std::int32_t> changed_;  // faces of this round's flips
};

}  // namespace

void flip_degenerate_edges(MeshArrays& arrays, Topology& topology, RepairLog& log, const Threads& threads, Job& job) {
  EdgeFlipper(arrays, topology, log, threads, job).run(threads, job);
}

}  // namespace isimp::detail
