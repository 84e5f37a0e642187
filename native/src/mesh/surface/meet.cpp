#include "isimp/mesh/meet.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>

namespace isimp {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Solid = Kernel::Triangle_3;

Point point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Solid solid(const Corners& t) { return {point(t[0]), point(t[1]), point(t[2])}; }

/// The side opposite a corner.
Kernel::Segment_3 side(const Solid& t, int corner) { return {t[corner + 1], t[corner + 2]}; }

}  // namespace

bool has_area(const Corners& triangle) { return !solid(triangle).is_degenerate(); }

int side_of(const Corners& triangle, const Vec3& p) {
  return static_cast<int>(CGAL::orientation(point(triangle[0]), point(triangle[1]), point(triangle[2]), point(p)));
}

bool meet_elsewhere(const Triangle& f, const Corners& s, const Triangle& g, const Corners& t) {
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
  if (shared == 3) return true;
  // Copies of a component in one place meet at corners. Exact arithmetic would decide each of their coplanar pairs.
  if (shared == 0 && std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end()) return true;
  const Solid a = solid(s), b = solid(t);
  if (shared == 0) return CGAL::do_intersect(a, b);
  if (shared == 1) {
    // Mostly one lies to one side of the other.
    const auto apart = [](const Solid& x, const Solid& y, int corner) {
      const CGAL::Orientation o = CGAL::orientation(x[0], x[1], x[2], y[corner + 1]);
      return o != CGAL::COPLANAR && o == CGAL::orientation(x[0], x[1], x[2], y[corner + 2]);
    };
    if (apart(a, b, j) || apart(b, a, i)) return false;
    return CGAL::do_intersect(b, side(a, i)) || CGAL::do_intersect(a, side(b, j));
  }
  // They share an edge: they meet elsewhere only if one lies folded on the other.
  const int free_f = 3 - sum_f, free_g = 3 - sum_g;
  const Point &p = a[free_f + 1], &q = a[free_f + 2], &r = a[free_f], &o = b[free_g];
  return CGAL::coplanar(p, q, r, o) && CGAL::coplanar_orientation(p, q, r, o) == CGAL::POSITIVE;
}

}  // namespace isimp
