#include "isimp/core/least_box.h"

#include <algorithm>
#include <cstddef>

namespace isimp::detail {
namespace {

using Vec2 = Eigen::Vector2d;

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Vec2> hull_of(std::vector<Vec2> points) {
  const auto before = [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  const auto add = [&](const Vec2& p, std::size_t least) {
    const auto turns_right = [&] {
      const Vec2 a = hull.back() - hull[hull.size() - 2], b = p - hull.back();
      return a.x() * b.y() - a.y() * b.x() <= 0;
    };
    while (hull.size() > least && turns_right()) hull.pop_back();
    hull.push_back(p);
  };
  for (const Vec2& p : points) add(p, 1);
  const std::size_t lower = hull.size();
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

}  // namespace

Eigen::Matrix2d least_box_turn(const std::vector<Vec2>& points) {
  const std::vector<Vec2> hull = hull_of(points);
  Eigen::Matrix2d best = Eigen::Matrix2d::Identity();
  double least = -1;
  for (std::size_t i = 0, h = hull.size() - 1; i < hull.size(); h = i++) {
    const Vec2 e = hull[i] - hull[h];
    if (!(e.norm() > 0)) continue;
    const Vec2 d = e.normalized();
    Eigen::Matrix2d turn;
    turn << d.x(), d.y(), -d.y(), d.x();
    Vec2 low = turn * hull[0], high = low;
    for (const Vec2& p : hull) {
      low = low.cwiseMin(turn * p);
      high = high.cwiseMax(turn * p);
    }
    const double area = (high - low).prod();
    if (least < 0 || area < least * (1 - 1e-9)) {  // the first of nearly equal ones, so that rounding does not choose
      least = area;
      best = turn;
    }
  }
  return best;
}

}  // namespace isimp::detail
