// Defects of one polygon: crossing, flipped, bent, not simple.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "isimp/core/noinline.h"
#include "judge/judge.h"

namespace isimp::meshing {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;

/// The polygon seen along its normal, turned counter-clockwise.
struct FlatPolygon {
  std::vector<Point> points;
  Vec3 normal = Vec3::Zero();   ///< its length is the area
  double bend = 0, extent = 0;  ///< largest distance from the plane, and from the middle
  bool convex = false;
};

namespace {

FlatPolygon flat(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  FlatPolygon f;
  std::vector<Vec3> p;
  p.reserve(polygon.size());
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t c : polygon) {
    p.push_back(rounded_to_float(position[c]));
    centre += p.back();
  }
  centre /= static_cast<double>(p.size());
  for (Vec3& x : p) {
    x -= centre;
    f.extent = std::max(f.extent, x.norm());
  }
  for (std::size_t i = 0; i < p.size(); ++i) f.normal += p[i].cross(p[i + 1 < p.size() ? i + 1 : 0]) / 2;
  const double area = f.normal.norm();
  if (area == 0) return f;
  const Vec3 n = f.normal / area;
  int axis = 0;
  n.cwiseAbs().minCoeff(&axis);
  const Vec3 u = n.cross(Vec3::Unit(axis)).normalized(), v = n.cross(u);
  f.points.reserve(p.size());
  for (const Vec3& x : p) {
    f.points.emplace_back(x.dot(u), x.dot(v));
    f.bend = std::max(f.bend, std::abs(x.dot(n)));
  }
  return f;
}

inline bool boxes_apart(const Point& a, const Point& b, const Point& c, const Point& d, double by) {
  return std::max(a.x(), b.x()) + by < std::min(c.x(), d.x()) || std::max(c.x(), d.x()) + by < std::min(a.x(), b.x()) ||
         std::max(a.y(), b.y()) + by < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) + by < std::min(a.y(), b.y());
}

/// Whether a point is less than a length from the segment from a to b.
bool is_near(const Point& p, const Point& a, const Point& b, double length) {
  const double x = b.x() - a.x(), y = b.y() - a.y(), u = p.x() - a.x(), v = p.y() - a.y();
  const double square = x * x + y * y, t = square > 0 ? std::clamp((x * u + y * v) / square, 0.0, 1.0) : 0;
  const double s = u - t * x, w = v - t * y;
  return s * s + w * w < length * length;
}

/// Whether the edges from a to b and from b to c fold: the end of the shorter one is on the longer one.
bool fold(const Point& a, const Point& b, const Point& c, double thickness) {
  const double x = a.x() - b.x(), y = a.y() - b.y(), u = c.x() - b.x(), v = c.y() - b.y();
  const double first = x * x + y * y, second = u * u + v * v;
  if (x * u + y * v <= 0 || std::min(first, second) < 16 * thickness * thickness) return false;
  return first < second ? is_near(a, b, c, thickness) : is_near(c, a, b, thickness);
}

/// Whether the polygon turns left at every corner and makes one full turn in all. Such a polygon is simple, and the
/// segment between any two of its corners lies inside.
/// Cost: O(n).
bool is_convex(const std::vector<Point>& p) {
  const std::size_t n = p.size();
  const auto rises = [](const Point& a, const Point& b) {  // whether the direction is one from 0 to 180 degrees
    return b.y() > a.y() || (b.y() == a.y() && b.x() > a.x());
  };
  int rounds = 0;
  bool before = rises(p[n - 2], p[n - 1]);
  for (std::size_t i = 0, last = n - 1, last_but_one = n - 2; i < n; last_but_one = last, last = i++) {
    if (CGAL::orientation(p[last_but_one], p[last], p[i]) != CGAL::LEFT_TURN) return false;
    const bool here = rises(p[last], p[i]);
    rounds += here && !before;
    before = here;
  }
  return rounds == 1;
}

/// Whether edge i touches edge j, j > i, elsewhere than where they follow each other. Corners that planes put on an edge are
/// off it by the rounding to float32, so less than `thickness` is a touch.
bool touch(const std::vector<Point>& p, std::size_t i, std::size_t j, double thickness) {
  const std::size_t n = p.size();
  const Point &a = p[i], &b = p[i + 1], &c = p[j], &d = p[j + 1 < n ? j + 1 : 0];
  if (j == i + 1)
    return fold(a, b, d, thickness) ||
           (CGAL::collinear(a, b, d) && !CGAL::collinear_are_strictly_ordered_along_line(a, b, d));
  if (i == 0 && j == n - 1)
    return fold(c, a, b, thickness) ||
           (CGAL::collinear(c, a, b) && !CGAL::collinear_are_strictly_ordered_along_line(c, a, b));
  if (boxes_apart(a, b, c, d, thickness)) return false;
  if (CGAL::do_intersect(Kernel::Segment_2(a, b), Kernel::Segment_2(c, d))) return true;
  // One short edge between both makes them no touch.
  return (j > i + 2 && (is_near(b, c, d, thickness) || is_near(c, a, b, thickness))) ||
         (j < i + n - 2 && (is_near(a, c, d, thickness) || is_near(d, a, b, thickness)));
}

constexpr std::size_t kSwept = 32;  ///< work: edges from which on the search is a sweep

/// As `find_crossing`, for many edges. The sweep takes edges in the order of their low ends along the longer side of the
/// polygon, and compares each with all edges that begin before it ends.
/// Cost: about O(n log n) for n short edges.
std::array<std::int32_t, 2> sweep_for_crossing(const std::vector<Point>& p, double thickness) {
  const auto n = p.size();
  double low[2] = {p[0].x(), p[0].y()}, high[2] = {low[0], low[1]};
  for (const Point& q : p)
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], q[k]);
      high[k] = std::max(high[k], q[k]);
    }
  const int axis = high[0] - low[0] >= high[1] - low[1] ? 0 : 1;
  struct Edge {
    double from, to;
    std::size_t index;
  };
  std::vector<Edge> edges(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double a = p[i][axis], b = p[i + 1 < n ? i + 1 : 0][axis];
    edges[i] = {std::min(a, b), std::max(a, b), i};
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.from < b.from; });
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n && edges[b].from <= edges[a].to + thickness; ++b) {
      const auto [i, j] = std::minmax(edges[a].index, edges[b].index);
      if (touch(p, i, j, thickness)) return {static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)};
    }
  return {-1, -1};
}

/// Two edges of the polygon that touch elsewhere than where they follow each other, {-1, -1} if it is simple.
/// Cost: O(n^2) for fewer than kSwept edges, else as `sweep_for_crossing`.
std::array<std::int32_t, 2> find_crossing(const std::vector<Point>& p, double thickness) {
  if (p.size() >= kSwept) return sweep_for_crossing(p, thickness);
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
    for (std::size_t j = i + 1; j < p.size(); ++j)
      if (touch(p, i, j, thickness)) return {static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)};
  return {-1, -1};
}

/// Cuts ears off a simple polygon, the one with the shortest diagonal first (the first one, where corners are many).
/// A cut changes only whether the two adjacent corners are ears: each triangle that contains corners contains one that is
/// not convex, and such a corner is not cut.
/// Cost: O(n (log n + k)) for k corners that are not convex and whose x lies within that of an ear, and moves of O(n^2)
/// numbers.
class EarClipper {
 public:
  EarClipper(const std::vector<Point>& points, std::span<const std::int32_t> polygon)
      : p_(points), polygon_(polygon), is_ear_(points.size(), Ear::unknown) {
    left_.resize(p_.size());
    std::iota(left_.begin(), left_.end(), std::size_t{0});
    for (const std::size_t i : left_)
      if (CGAL::orientation(p_[before(i)], p_[i], p_[after(i)]) != CGAL::LEFT_TURN) not_convex_.push_back(i);
    std::sort(not_convex_.begin(), not_convex_.end(), [&](std::size_t i, std::size_t j) { return x(i) < x(j); });
  }

  void cut(const Facet& like, std::vector<Facet>& facets) {
    while (left_.size() > 3) {
      const std::size_t ear = find();
      if (ear == left_.size()) return;  // only if rounding made the polygon not simple
      add(ear, like, facets);
      is_ear_[before(ear)] = is_ear_[after(ear)] = Ear::unknown;
      first_ = ear + 1 < left_.size() ? ear - std::min<std::size_t>(ear, 1) : 0;
      take_out(left_[ear]);
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    add(1, like, facets);
  }

 private:
  static constexpr std::size_t kMany = 48;  // work
  enum class Ear : std::uint8_t { unknown, yes, no };
  [[nodiscard]] double x(std::size_t i) const { return p_[i].x(); }
  [[nodiscard]] std::size_t before(std::size_t i) const { return left_[i > 0 ? i - 1 : left_.size() - 1]; }
  [[nodiscard]] std::size_t after(std::size_t i) const { return left_[i + 1 < left_.size() ? i + 1 : 0]; }

  void add(std::size_t i, Facet like, std::vector<Facet>& facets) const {
    like.corner = {polygon_[before(i)], polygon_[left_[i]], polygon_[after(i)]};
    facets.push_back(like);
  }

  /// The first of the corners that are not convex with at least this x.
  [[nodiscard]] auto not_left_of(double least) const {
    return std::lower_bound(not_convex_.begin(), not_convex_.end(), least,
                            [&](std::size_t i, double value) { return x(i) < value; });
  }

  void take_out(std::size_t corner) {
    auto at = not_left_of(x(corner));
    while (at != not_convex_.end() && *at != corner && x(*at) == x(corner)) ++at;
    if (at != not_convex_.end() && *at == corner) not_convex_.erase(at);
  }

  [[nodiscard]] std::size_t find() {
    std::size_t best = left_.size();
    double shortest = 0;
    if (left_.size() > kMany) {
      while (first_ < left_.size() && !knows_ear(first_)) ++first_;
      return first_;
    }
    for (std::size_t i = 0; i < left_.size(); ++i) {
      const double diagonal = CGAL::squared_distance(p_[before(i)], p_[after(i)]);
      if ((best < left_.size() && diagonal >= shortest) || !knows_ear(i)) continue;
      best = i;
      shortest = diagonal;
    }
    return best;
  }

  bool knows_ear(std::size_t i) {
    Ear& ear = is_ear_[left_[i]];
    if (ear == Ear::unknown) ear = is_ear(i) ? Ear::yes : Ear::no;
    return ear == Ear::yes;
  }

  [[nodiscard]] bool is_ear(std::size_t i) const {
    const Point &a = p_[before(i)], &b = p_[left_[i]], &c = p_[after(i)];
    if (CGAL::orientation(a, b, c) != CGAL::LEFT_TURN) return false;
    const auto [left, right] = std::minmax({a.x(), b.x(), c.x()});
    const auto [low, high] = std::minmax({a.y(), b.y(), c.y()});
    for (auto at = not_left_of(left); at != not_convex_.end() && x(*at) <= right; ++at) {
      const std::size_t k = *at;
      const Point& q = p_[k];
      if (q.y() < low || q.y() > high) continue;
      if (k == before(i) || k == left_[i] || k == after(i)) continue;
      if (CGAL::orientation(a, b, q) != CGAL::RIGHT_TURN && CGAL::orientation(b, c, q) != CGAL::RIGHT_TURN &&
          CGAL::orientation(c, a, q) != CGAL::RIGHT_TURN)
        return false;
    }
    return true;
  }

  const std::vector<Point>& p_;
  std::span<const std::int32_t> polygon_;
  std::vector<std::size_t> left_, not_convex_;  // corners that are left; by x, the ones that were not convex
  std::size_t first_ = 0;    // no corner of `left_` before this one is an ear, where corners are many
  std::vector<Ear> is_ear_;  // by corner
};

/// The triangulation of a simple bent polygon with the least surface, among all that do not fold over along the normal.
/// No segment is tested against the boundary: triangles that all turn left along the normal, with the polygon as their
/// common boundary, cover each point as often as it winds around the point, so they cover its inside once.
/// Source: Gilbert 1979.
/// Cost: O(n^3).
class LeastSurface {
 public:
  static constexpr std::size_t kMostCorners = 64;  ///< limit: most corners of a polygon

  /// \param thin  triangles thinner than this are used only if there is no other way; 0: no bound
  LeastSurface(const std::vector<Point>& points, bool convex, std::span<const std::int32_t> polygon,
               std::span<const Vec3> position, double thin)
      : p_(points), convex_(convex), thin_(thin), polygon_(polygon), n_(points.size()) {
    for (std::size_t i = 0; i < n_; ++i) {
      at_[i] = position[polygon[i]];
      if (i > 0) cost_[(i - 1) * n_ + i] = cost_[i * n_ + i - 1] = 0;
    }
  }

  /// \return whether there is one
  bool cut(const Facet& like, std::vector<Facet>& facets) {
    for (std::size_t gap = 2; gap < n_; ++gap)
      for (std::size_t i = 0; i + gap < n_; ++i) cost_[i * n_ + i + gap] = cost_[(i + gap) * n_ + i] = best(i, i + gap);
    if (cost_[n_ - 1] >= kNever) return false;
    collect(0, n_ - 1, like, facets);
    return true;
  }

 private:
  static constexpr double kNever = 1e300;  // mark
  static constexpr double kSliver = 1e18;  ///< mark: cost of a sliver: more than any surface, in squares of `thin`

  static double longest(const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  }

  [[nodiscard]] ISIMP_NOINLINE bool turns_left(std::size_t i, std::size_t k, std::size_t j) const {
    return CGAL::orientation(p_[i], p_[k], p_[j]) == CGAL::LEFT_TURN;
  }

  /// The least surface between the corners i to j and the segment that joins them, kNever if none is possible.
  ISIMP_NOINLINE double best(std::size_t i, std::size_t j) {
    const double *of_i = &cost_[i * n_], *of_j = &cost_[j * n_];
    // rounding: A triangle that is too large for a smaller surface is skipped before its root and its turn are computed.
    constexpr double kRounding = 1 + 1e-9;
    double least = kNever;
    const Vec3 &a = at_[i], &c = at_[j], side_c = c - a;
    for (std::size_t k = i + 1; k < j; ++k) {
      const double rest = of_i[k] + of_j[k];
      if (rest >= least) continue;
      const Vec3& b = at_[k];
      const double squared = (b - a).cross(side_c).squaredNorm(), most = least - rest;
      if (squared > kRounding * most * most) continue;
      if (!convex_ && !turns_left(i, k, j)) continue;
      const double doubled = std::sqrt(squared);
      double sum = rest + doubled;
      if (thin_ > 0 && doubled <= thin_ * longest(a, b, c)) sum += kSliver * thin_ * thin_;
      if (sum >= least) continue;
      least = sum;
      via_[i * n_ + j] = static_cast<std::uint8_t>(k);
    }
    return least;
  }

  void collect(std::size_t i, std::size_t j, Facet like, std::vector<Facet>& facets) const {
    if (j - i < 2) return;
    const std::size_t k = via_[i * n_ + j];
    like.corner = {polygon_[i], polygon_[k], polygon_[j]};
    facets.push_back(like);
    collect(i, k, like, facets);
    collect(k, j, like, facets);
  }

  const std::vector<Point>& p_;
  const bool convex_;
  const double thin_;
  std::span<const std::int32_t> polygon_;
  const std::size_t n_;
  // By corner, or by two corners: arrays in place, as most polygons have few corners and would wait for the allocations.
  std::array<Vec3, kMostCorners> at_;
  std::array<double, kMostCorners * kMostCorners> cost_;
  std::array<std::uint8_t, kMostCorners * kMostCorners> via_;
};

}  // namespace

PolygonDefects judge_polygon(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Vec3& normal,
                             const Bounds& bounds, FlatView* view) {
  PolygonDefects found;
  FlatPolygon f = flat(polygon, position);
  found.bend = f.bend;
  if (f.points.empty() || f.normal.norm() <= bounds.thickness * f.extent) {
    found.kinds = kNoArea;
    return found;
  }
  if (f.normal.dot(normal) <= bounds.facing * f.normal.norm()) found.kinds |= kFlipped;
  if (bounds.bend > 0 && f.bend > bounds.bend) found.kinds |= kBent;
  f.convex = is_convex(f.points);
  if (!f.convex) found.crossing = find_crossing(f.points, bounds.thickness);
  if (found.crossing[0] >= 0)
    found.kinds |= kCrossing;
  else if (view)
    *view = std::make_shared<const FlatPolygon>(std::move(f));
  return found;
}

void triangulate(const FlatPolygon& view, std::span<const std::int32_t> polygon, std::span<const Vec3> position,
                 const Bounds& bounds, const Facet& like, std::vector<Facet>& facets) {
  const std::size_t n = view.points.size();
  if (n <= 3 || n > LeastSurface::kMostCorners ||
      !LeastSurface(view.points, view.convex, polygon, position, bounds.no_slivers ? 4 * bounds.thickness : 0)
           .cut(like, facets))
    EarClipper(view.points, polygon).cut(like, facets);
}

}  // namespace isimp::meshing
