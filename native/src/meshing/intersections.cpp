#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "isimp/mesh/meet.h"
#include "judge.h"

namespace isimp::meshing {
namespace {

Vec3 stored(const Vec3& p) { return p.cast<float>().cast<double>(); }

struct Box {
  Vec3 low, high;
  std::int32_t index;  ///< the caller's

  Box(const Corners& t, std::int32_t i)
      : low(t[0].cwiseMin(t[1]).cwiseMin(t[2])), high(t[0].cwiseMax(t[1]).cwiseMax(t[2])), index(i) {}

  [[nodiscard]] bool apart(const Vec3& other_low, const Vec3& other_high) const {
    return (low.array() > other_high.array()).any() || (high.array() < other_low.array()).any();
  }
};

/// The middle of where the edges of two triangles pass through the other one; of the smaller's if none does.
Vec3 meeting_place(const Corners& f, const Corners& g) {
  Vec3 sum = Vec3::Zero();
  int found = 0;
  for (const auto* t : {&f, &g}) {
    const Corners& other = t == &f ? g : f;
    const Vec3 u = other[1] - other[0], v = other[2] - other[0], n = u.cross(v);
    for (int k = 0; k < 3; ++k) {
      const Vec3 &p = (*t)[k], &q = (*t)[(k + 1) % 3];
      const double from = (p - other[0]).dot(n), to = (q - other[0]).dot(n);
      if (from * to >= 0) continue;
      const Vec3 x = p + (q - p) * (from / (from - to)), d = x - other[0];
      const double s = d.cross(v).dot(n), t2 = u.cross(d).dot(n);
      if (s < 0 || t2 < 0 || s + t2 > n.squaredNorm()) continue;
      sum += x;
      ++found;
    }
  }
  if (found > 0) return sum / found;
  const auto area = [](const Corners& t) { return (t[1] - t[0]).cross(t[2] - t[0]).squaredNorm(); };
  const Corners& small = area(f) < area(g) ? f : g;
  return (small[0] + small[1] + small[2]) / 3;
}

/// A tree of boxes, to look for those that meet a given one: halved at the median of their middles, along the axis on
/// which these spread most, down to a few. Cost: O(n log n) to make; a search, about O(log n + boxes that it meets).
class BoxTree {
 public:
  explicit BoxTree(std::vector<Box> all) : all_(std::move(all)) {
    if (!all_.empty()) make(0, static_cast<std::int32_t>(all_.size()));
  }

  /// Whether some box has a place in common with `a` and passes the test; stops at the first.
  template <class Test>
  [[nodiscard]] bool any(const Box& a, Test test) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      if (node.around.apart(a.low, a.high)) {
        n = node.after;
        continue;
      }
      if (node.is_leaf)
        for (std::int32_t i = node.begin; i < node.end; ++i)
          if (!all_[i].apart(a.low, a.high) && test(all_[i])) return true;
      ++n;
    }
    return false;
  }

 private:
  struct Node {
    Box around;
    std::int32_t begin, end;
    bool is_leaf;
    std::size_t after;  ///< the node that follows where nothing below this one is asked for
  };
  static constexpr std::int32_t kLeaf = 8;

  /// Nodes stand before those below them.
  void make(std::int32_t begin, std::int32_t end) {
    Box around = all_[begin];
    Vec3 low = middle(around), high = low;
    for (std::int32_t i = begin + 1; i < end; ++i) {
      around.low = around.low.cwiseMin(all_[i].low);
      around.high = around.high.cwiseMax(all_[i].high);
      low = low.cwiseMin(middle(all_[i]));
      high = high.cwiseMax(middle(all_[i]));
    }
    const std::size_t node = nodes_.size();
    nodes_.push_back({around, begin, end, end - begin <= kLeaf, 0});
    if (!nodes_[node].is_leaf) {
      int axis = 0;
      (high - low).maxCoeff(&axis);
      const std::int32_t half = begin + (end - begin) / 2;
      std::nth_element(all_.begin() + begin, all_.begin() + half, all_.begin() + end, [&](const Box& x, const Box& y) {
        return x.low[axis] + x.high[axis] < y.low[axis] + y.high[axis];
      });
      make(begin, half);
      make(half, end);
    }
    nodes_[node].after = nodes_.size();
  }

  static Vec3 middle(const Box& b) { return (b.low + b.high) / 2; }

  std::vector<Box> all_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<Hit> find_hits(std::span<const Facet> facets, std::span<const Vec3> position,
                           const std::vector<bool>& changed) {
  std::vector<Corners> solids;
  std::vector<Box> all, moved;
  solids.reserve(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const auto& c = facets[i].corner;
    solids.push_back({stored(position[c[0]]), stored(position[c[1]]), stored(position[c[2]])});
    if (!has_area(solids[i])) continue;
    all.emplace_back(solids[i], static_cast<std::int32_t>(i));
    if (changed[facets[i].piece]) moved.push_back(all.back());
  }
  std::vector<std::array<std::int32_t, 2>> met;
  const BoxTree search(std::move(moved));  // fewer than all of them
  for (const Box& x : all) {
    const std::int32_t i = x.index;
    const Facet& f = facets[i];
    (void)search.any(x, [&](const Box& y) {
      const std::int32_t j = y.index;
      const Facet& g = facets[j];
      const bool seen_from_there = j <= i && changed[f.piece];
      if (seen_from_there || (f.piece == g.piece && f.part == g.part)) return false;
      if (meet_elsewhere(f.corner, solids[i], g.corner, solids[j])) met.push_back({std::min(i, j), std::max(i, j)});
      return false;
    });
  }
  // Facets come by piece and part, so the lower one is of the lower polygon.
  std::sort(met.begin(), met.end());
  std::vector<Hit> hits;
  const auto corners = [&](const Facet& f) {
    return Corners{position[f.corner[0]], position[f.corner[1]], position[f.corner[2]]};
  };
  for (const auto& [i, j] : met) {
    const Facet &f = facets[i], &g = facets[j];
    hits.push_back({f.piece,
                    f.part,
                    g.piece,
                    g.part,
                    meeting_place(corners(f), corners(g)),
                    {f.corner[0], f.corner[1], f.corner[2], g.corner[0], g.corner[1], g.corner[2]}});
  }
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& x, const Hit& y) { return x.key() < y.key(); });
  hits.erase(std::unique(hits.begin(), hits.end(), [](const Hit& x, const Hit& y) { return x.key() == y.key(); }),
             hits.end());
  return hits;
}

bool scan_intersects(const Mesh& mesh, std::span<const std::int32_t> faces, std::span<const std::int32_t> others) {
  std::vector<Facet> facets;
  std::vector<Corners> solids;
  const auto boxes = [&](std::span<const std::int32_t> some) {
    std::vector<Box> result;
    for (const std::int32_t f : some) {
      const Triangle& t = mesh.triangles()[f];
      const Corners s{stored(mesh.vertices()[t[0]]), stored(mesh.vertices()[t[1]]), stored(mesh.vertices()[t[2]])};
      if (!has_area(s)) continue;
      result.emplace_back(s, static_cast<std::int32_t>(solids.size()));
      solids.push_back(s);
      facets.push_back({t, f, 0});
    }
    return result;
  };
  const std::vector<Box> some = boxes(faces);
  const BoxTree search(boxes(others));
  return std::any_of(some.begin(), some.end(), [&](const Box& x) {
    return search.any(x, [&](const Box& y) {
      const std::int32_t i = x.index, j = y.index;
      return facets[i].piece != facets[j].piece &&
             meet_elsewhere(facets[i].corner, solids[i], facets[j].corner, solids[j]);
    });
  });
}

}  // namespace isimp::meshing
