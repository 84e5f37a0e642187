#include <CGAL/Bbox_3.h>
#include <CGAL/box_intersection_d.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "isimp/mesh/meet.h"
#include "judge.h"

namespace isimp::meshing {
namespace {

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::int32_t>;

Vec3 stored(const Vec3& p) { return p.cast<float>().cast<double>(); }

CGAL::Bbox_3 box_of(const Corners& t) {
  const Vec3 low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  return {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
}

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

/// Calls test(a, b) for each box a of `some` and each other b of `all` that have a place in common.
/// Cost: O(n log n + pairs that overlap along one axis), which for few boxes is less than to build a tree.
template <class Test>
void for_each_meeting(std::span<const Box> some, std::vector<Box>& all, Test test) {
  std::sort(all.begin(), all.end(), [](const Box& x, const Box& y) {
    return x.min_coord(0) < y.min_coord(0) || (x.min_coord(0) == y.min_coord(0) && x.info() < y.info());
  });
  double widest = 0;
  for (const Box& b : all) widest = std::max(widest, b.max_coord(0) - b.min_coord(0));
  for (const Box& a : some) {
    auto b = std::lower_bound(all.begin(), all.end(), a.min_coord(0) - widest,
                              [](const Box& x, double low) { return x.min_coord(0) < low; });
    for (; b != all.end() && b->min_coord(0) <= a.max_coord(0); ++b) {
      bool apart = b->info() == a.info();
      for (int axis = 0; axis < 3; ++axis)
        apart = apart || b->max_coord(axis) < a.min_coord(axis) || a.max_coord(axis) < b->min_coord(axis);
      if (!apart) test(a, *b);
    }
  }
}

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
    all.emplace_back(box_of(solids[i]), static_cast<std::int32_t>(i));
    if (changed[facets[i].piece]) moved.push_back(all.back());
  }
  std::vector<std::array<std::int32_t, 2>> met;
  const auto test = [&](const Box& x, const Box& y) {
    const std::int32_t i = x.info(), j = y.info();
    const Facet &f = facets[i], &g = facets[j];
    if (f.piece == g.piece && f.part == g.part) return;
    if (meet_elsewhere(f.corner, solids[i], g.corner, solids[j])) met.push_back({std::min(i, j), std::max(i, j)});
  };
  if (moved.size() == all.size()) {
    CGAL::box_self_intersection_d(all.begin(), all.end(), test);
  } else {
    for_each_meeting(moved, all, test);
  }
  // Facets come by piece and part, so the lower one is of the lower polygon.
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
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
      const Corners s{mesh.vertices()[t[0]], mesh.vertices()[t[1]], mesh.vertices()[t[2]]};
      if (!has_area(s)) continue;
      result.emplace_back(box_of(s), static_cast<std::int32_t>(solids.size()));
      solids.push_back(s);
      facets.push_back({t, f, 0});
    }
    return result;
  };
  std::vector<Box> a = boxes(faces), b = boxes(others);
  bool found = false;
  CGAL::box_intersection_d(a.begin(), a.end(), b.begin(), b.end(), [&](const Box& x, const Box& y) {
    const std::int32_t i = x.info(), j = y.info();
    found = found || (facets[i].piece != facets[j].piece &&
                      meet_elsewhere(facets[i].corner, solids[i], facets[j].corner, solids[j]));
  });
  return found;
}

}  // namespace isimp::meshing
