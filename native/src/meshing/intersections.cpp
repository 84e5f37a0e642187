#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "isimp/mesh/meet.h"
#include "judge.h"

namespace isimp::meshing {
namespace {

Vec3 stored(const Vec3& p) { return p.cast<float>().cast<double>(); }

struct Box {
  Vec3 low, high;
  std::int32_t index;   ///< the caller's
  int width_class = 0;  ///< for Boxes

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

/// Boxes to look for those that meet a given one.
///
/// They are sorted along one axis, in classes of like width, so that one that is wide does not make the search for all
/// others long. Cost: O(n log n) to make; a search, O(boxes that overlap along that axis).
class Boxes {
 public:
  explicit Boxes(std::vector<Box> all) : all_(std::move(all)) {
    if (all_.empty()) return;
    low_ = all_[0].low;
    high_ = all_[0].high;
    for (const Box& b : all_) {
      low_ = low_.cwiseMin(b.low);
      high_ = high_.cwiseMax(b.high);
    }
    const double extent = (high_ - low_).maxCoeff(&axis_);
    for (Box& b : all_) {
      const double share = (b.high[axis_] - b.low[axis_]) / extent;  // not a number where there is no extent
      b.width_class = std::ilogb(share > kNarrowest ? share : kNarrowest);
    }
    std::sort(all_.begin(), all_.end(), [&](const Box& x, const Box& y) {
      return std::tuple(x.width_class, x.low[axis_], x.index) < std::tuple(y.width_class, y.low[axis_], y.index);
    });
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (i == 0 || all_[i].width_class != all_[i - 1].width_class) classes_.push_back({i, i, 0});
      classes_.back().end = i + 1;
      classes_.back().widest = std::max(classes_.back().widest, all_[i].high[axis_] - all_[i].low[axis_]);
    }
  }

  /// Whether some box has a place in common with `a` and passes the test; stops at the first.
  template <class Test>
  [[nodiscard]] bool any(const Box& a, Test test) const {
    if (all_.empty() || a.apart(low_, high_)) return false;
    for (const Class& c : classes_) {
      const auto end = all_.begin() + static_cast<std::ptrdiff_t>(c.end);
      auto b = std::lower_bound(all_.begin() + static_cast<std::ptrdiff_t>(c.begin), end, a.low[axis_] - c.widest,
                                [&](const Box& x, double low) { return x.low[axis_] < low; });
      for (; b != end && b->low[axis_] <= a.high[axis_]; ++b)
        if (!b->apart(a.low, a.high) && test(*b)) return true;
    }
    return false;
  }

 private:
  struct Class {
    std::size_t begin, end;
    double widest;
  };
  static constexpr double kNarrowest = 1.0 / 1024;  ///< of the extent: narrower boxes are one class

  std::vector<Box> all_;
  std::vector<Class> classes_;
  Vec3 low_, high_;
  int axis_ = 0;
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
  const Boxes search(std::move(all));
  for (const Box& x : moved) {
    const std::int32_t i = x.index;
    const Facet& f = facets[i];
    (void)search.any(x, [&](const Box& y) {
      const std::int32_t j = y.index;
      const Facet& g = facets[j];
      const bool seen_from_there = j <= i && changed[g.piece];
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
  const Boxes search(boxes(others));
  return std::any_of(some.begin(), some.end(), [&](const Box& x) {
    return search.any(x, [&](const Box& y) {
      const std::int32_t i = x.index, j = y.index;
      return facets[i].piece != facets[j].piece &&
             meet_elsewhere(facets[i].corner, solids[i], facets[j].corner, solids[j]);
    });
  });
}

}  // namespace isimp::meshing
