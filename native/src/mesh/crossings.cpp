#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include "close.h"

namespace isimp::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Solid = Kernel::Triangle_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::int32_t>;

/// Whether two triangles meet elsewhere than in the corners and the edge they share. \param s, t  their points
bool meet_elsewhere(const Triangle& f, const Solid& s, const Triangle& g, const Solid& t) {
  int shared = 0, i = 0, j = 0, sum_f = 0, sum_g = 0;
  for (int k = 0; k < 3; ++k)
    for (int m = 0; m < 3; ++m) {
      if (f[k] != g[m]) continue;
      ++shared;
      i = k;
      j = m;
      sum_f += k;
      sum_g += m;
    }
  if (shared == 0) return CGAL::do_intersect(s, t);
  if (shared == 1)
    return CGAL::do_intersect(t, Kernel::Segment_3(s[i + 1], s[i + 2])) ||
           CGAL::do_intersect(s, Kernel::Segment_3(t[j + 1], t[j + 2]));
  if (shared == 3) return true;
  // They share an edge: they meet elsewhere only if one lies folded on the other.
  const Point &p = s[4 - sum_f], &q = s[5 - sum_f], &r = s[3 - sum_f], &o = t[3 - sum_g];
  return CGAL::coplanar(p, q, r, o) && CGAL::coplanar_orientation(p, q, r, o) == CGAL::POSITIVE;
}

}  // namespace

std::vector<char> find_crossed(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                               const std::vector<char>& removed, std::size_t fresh, Job& job) {
  const auto solid = [&](std::int32_t f) {
    const auto corner = [&](int k) {
      const Vec3& p = vertices[triangles[f][k]];
      return Point(p.x(), p.y(), p.z());
    };
    return Solid(corner(0), corner(1), corner(2));
  };
  const std::size_t old = triangles.size() - fresh;
  CGAL::Bbox_3 reach;
  std::vector<Box> patches, others;
  for (std::size_t f = old; f < triangles.size(); ++f) {
    patches.emplace_back(solid(static_cast<std::int32_t>(f)).bbox(), static_cast<std::int32_t>(f));
    reach += patches.back().bbox();
  }
  for_each_index(triangles.size(), job, [&](std::size_t f) {
    if (removed[f]) return;
    const CGAL::Bbox_3 box = solid(static_cast<std::int32_t>(f)).bbox();
    if (CGAL::do_overlap(box, reach)) others.emplace_back(box, static_cast<std::int32_t>(f));
  });
  std::vector<char> crossed(fresh, 0);
  std::size_t tests = 0;
  CGAL::box_intersection_d(patches.begin(), patches.end(), others.begin(), others.end(),
                           [&](const Box& x, const Box& y) {
                             if (++tests % kPollEvery == 0) job.poll();
                             const std::int32_t f = x.info(), g = y.info();
                             if (f == g || crossed[f - old]) return;
                             const Solid s = solid(f), t = solid(g);
                             if (!s.is_degenerate() && !t.is_degenerate())
                               crossed[f - old] = meet_elsewhere(triangles[f], s, triangles[g], t);
                           });
  return crossed;
}

}  // namespace isimp::detail
