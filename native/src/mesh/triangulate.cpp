#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

#include "edge_groups.h"
#include "isimp/mesh/io.h"

namespace isimp {
namespace {

using Vec2 = Eigen::Vector2d;

/// Twice the area of a triangle, positive if it runs counter-clockwise.
double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Cuts ears off one polygon at a time; keeps its memory between them.
class EarCutter {
 public:
  EarCutter(const std::vector<Vec3>& vertices, Triangulation& result) : vertices_(vertices), result_(result) {}

  void cut(std::span<const std::int32_t> polygon, std::int32_t number, Job& job) {
    const auto n = static_cast<std::int32_t>(polygon.size());
    const auto emit = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
      result_.triangles.push_back({polygon[a], polygon[b], polygon[c]});
      result_.source_polygon.push_back(number);
    };
    if (n < 3) return;
    if (n == 3) return emit(0, 1, 2);
    flatten(polygon);
    link(n);
    std::int32_t at = 0;
    if (n == 4) at = (flat_[0] - flat_[2]).squaredNorm() <= (flat_[1] - flat_[3]).squaredNorm() ? 1 : 0;  // the shorter
    for (std::int32_t left = n, tried = 0; left > 3;) {
      if (++steps_ % kEarsBetweenPolls == 0) job.poll();
      if (tried < left && !is_ear(at)) {
        at = next_[at];
        ++tried;
        continue;
      }
      if (tried >= left) at = widest(at);  // no ear: the polygon has no area or crosses itself
      emit(previous_[at], at, next_[at]);
      at = remove(at);
      --left;
      tried = 0;
      if (left == 3) emit(previous_[at], at, next_[at]);
    }
  }

 private:
  static constexpr std::size_t kEarsBetweenPolls = 1024;

  /// Puts the polygon into the plane across its vector area (Newell), where it runs counter-clockwise, lengthwise along
  /// the first axis.
  void flatten(std::span<const std::int32_t> polygon) {
    const Vec3& origin = vertices_[polygon[0]];
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      area += (vertices_[polygon[i]] - origin).cross(vertices_[polygon[i + 1]] - origin);
    const Vec3 normal = area.normalized();
    Vec3 along = Vec3::Zero();
    for (const std::int32_t v : polygon)
      if (const Vec3 p = vertices_[v] - origin; p.squaredNorm() > along.squaredNorm()) along = p;
    const Vec3 x = (along - normal * normal.dot(along)).normalized(), y = normal.cross(x);
    flat_.clear();
    for (const std::int32_t v : polygon) {
      const Vec3 p = vertices_[v] - origin;
      flat_.emplace_back(p.dot(x), p.dot(y));
    }
  }
  void link(std::int32_t n) {
    previous_.resize(n);
    next_.resize(n);
    for (std::int32_t i = 0; i < n; ++i) {
      previous_[i] = i == 0 ? n - 1 : i - 1;
      next_[i] = i == n - 1 ? 0 : i + 1;
    }
    is_reflex_.assign(n, 0);
    reflex_.clear();
    for (std::int32_t i = 0; i < n; ++i) {
      if (corner(i) > 0) continue;
      is_reflex_[i] = 1;
      reflex_.push_back(i);
    }
    std::sort(reflex_.begin(), reflex_.end(),
              [&](std::int32_t i, std::int32_t j) { return std::pair(flat_[i].x(), i) < std::pair(flat_[j].x(), j); });
  }
  [[nodiscard]] double corner(std::int32_t i) const { return turn(flat_[previous_[i]], flat_[i], flat_[next_[i]]); }

  /// Whether the triangle at a convex corner holds no other corner; only reflex ones can lie in it.
  [[nodiscard]] bool is_ear(std::int32_t i) const {
    if (!(corner(i) > 0)) return false;
    const std::int32_t p = previous_[i], n = next_[i];
    const Vec2 &a = flat_[p], &b = flat_[i], &c = flat_[n];
    const auto [left, right] = std::minmax({a.x(), b.x(), c.x()});
    const auto is_left = [&](std::int32_t r, double x) { return flat_[r].x() < x; };
    for (auto at = std::lower_bound(reflex_.begin(), reflex_.end(), left, is_left); at != reflex_.end(); ++at) {
      const std::int32_t r = *at;
      const Vec2& q = flat_[r];
      if (q.x() > right) break;
      if (!is_reflex_[r] || r == p || r == i || r == n) continue;
      if (q == a || q == b || q == c) continue;  // a bridge to a hole names its ends twice
      if (turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0) return false;
    }
    return true;
  }
  /// The corner that turns most to the left.
  [[nodiscard]] std::int32_t widest(std::int32_t start) const {
    std::int32_t best = start;
    for (std::int32_t i = next_[start]; i != start; i = next_[i])
      if (corner(i) > corner(best)) best = i;
    return best;
  }
  /// Takes a corner out; returns the one from which to go on, two further, so that fans do not arise.
  std::int32_t remove(std::int32_t i) {
    const std::int32_t p = previous_[i], n = next_[i];
    next_[p] = n;
    previous_[n] = p;
    is_reflex_[i] = 0;
    for (const std::int32_t r : {p, n})
      if (corner(r) > 0) is_reflex_[r] = 0;
    return next_[n];
  }

  const std::vector<Vec3>& vertices_;
  Triangulation& result_;
  std::vector<Vec2> flat_;
  std::vector<std::int32_t> previous_, next_;
  std::vector<std::int32_t> reflex_;  // by x, those that no longer are among them
  std::vector<char> is_reflex_;
  std::size_t steps_ = 0;
};

}  // namespace

Triangulation triangulate(const PolygonSoup& soup, Job& job) {
  Triangulation result;
  result.triangles.reserve(soup.loops.size() / 3);
  result.source_polygon.reserve(soup.loops.size() / 3);
  EarCutter cutter(soup.vertices, result);
  for (std::int32_t q = 0; q < soup.polygon_count(); ++q) {
    if (q % detail::kPollEvery == 0) job.poll();
    cutter.cut(soup.polygon(q), q, job);
  }
  return result;
}

}  // namespace isimp
