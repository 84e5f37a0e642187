#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <vector>

#include "judge.h"

namespace isimp::meshing {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Solid = Kernel::Triangle_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::int32_t>;

Point point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Point stored(const Vec3& p) { return point(p.cast<float>().cast<double>()); }

/// Whether two triangles that share the vertices a[i] = b[j] alone meet elsewhere.
bool meet_beyond_vertex(const Solid& a, int i, const Solid& b, int j) {
  return CGAL::do_intersect(b, Kernel::Segment_3(a[(i + 1) % 3], a[(i + 2) % 3])) ||
         CGAL::do_intersect(a, Kernel::Segment_3(b[(j + 1) % 3], b[(j + 2) % 3]));
}

/// Whether two triangles meet elsewhere than in the corners and the edge they share.
bool meet(const Facet& f, const Solid& a, const Facet& g, const Solid& b) {
  int shared = 0, i = 0, j = 0, sum_f = 0, sum_g = 0;
  for (int k = 0; k < 3; ++k)
    for (int m = 0; m < 3; ++m) {
      if (f.corner[k] != g.corner[m]) continue;
      ++shared;
      i = k;
      j = m;
      sum_f += k;
      sum_g += m;
    }
  if (shared == 0) return CGAL::do_intersect(a, b);
  if (shared == 1) return meet_beyond_vertex(a, i, b, j);
  if (shared == 3) return true;
  // They share an edge: they meet elsewhere only if one lies folded on the other.
  const int free_f = 3 - sum_f, free_g = 3 - sum_g;
  const Point &p = a[(free_f + 1) % 3], &q = a[(free_f + 2) % 3], &r = a[free_f], &s = b[free_g];
  return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
}

}  // namespace

std::vector<Hit> find_hits(std::span<const Facet> facets, std::span<const Vec3> position,
                           const std::vector<bool>& changed) {
  std::vector<Solid> solids;
  std::vector<Box> all, moved;
  solids.reserve(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const auto& c = facets[i].corner;
    solids.emplace_back(stored(position[c[0]]), stored(position[c[1]]), stored(position[c[2]]));
    if (solids[i].is_degenerate()) continue;
    all.emplace_back(solids[i].bbox(), static_cast<std::int32_t>(i));
    if (changed[facets[i].piece]) moved.push_back(all.back());
  }
  std::vector<Hit> hits;
  const auto test = [&](const Box& x, const Box& y) {
    const std::int32_t i = x.info(), j = y.info();
    const Facet &f = facets[i], &g = facets[j];
    if (f.piece == g.piece && f.part == g.part) return;
    if (meet(f, solids[i], g, solids[j])) hits.push_back({std::min(f.piece, g.piece), std::max(f.piece, g.piece)});
  };
  if (moved.size() == all.size()) {
    CGAL::box_self_intersection_d(all.begin(), all.end(), test);
  } else {
    CGAL::box_intersection_d(moved.begin(), moved.end(), all.begin(), all.end(), test);
  }
  std::sort(hits.begin(), hits.end());
  hits.erase(std::unique(hits.begin(), hits.end()), hits.end());
  return hits;
}

bool scan_intersects(Labels& labels, std::int32_t piece, std::int32_t other) {
  const Mesh& mesh = labels.mesh;
  std::vector<Solid> solids;
  std::vector<std::int32_t> face;
  const auto boxes = [&](std::int32_t l) {
    std::vector<Box> result;
    for (const std::int32_t f : labels.faces_of(l)) {
      const Triangle& t = mesh.triangles()[f];
      const Solid s(point(mesh.vertices()[t[0]]), point(mesh.vertices()[t[1]]), point(mesh.vertices()[t[2]]));
      if (s.is_degenerate()) continue;
      result.emplace_back(s.bbox(), static_cast<std::int32_t>(solids.size()));
      solids.push_back(s);
      face.push_back(f);
    }
    return result;
  };
  std::vector<Box> a = boxes(piece), b = boxes(other);
  bool found = false;
  CGAL::box_intersection_d(a.begin(), a.end(), b.begin(), b.end(), [&](const Box& x, const Box& y) {
    if (found) return;
    const Solid &s = solids[x.info()], &t = solids[y.info()];
    for (int k = 0; k < 3; ++k)
      for (int m = 0; m < 3; ++m)
        if (s[k] == t[m]) return;
    found = CGAL::do_intersect(s, t);
  });
  return found;
}

}  // namespace isimp::meshing
