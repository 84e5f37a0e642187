#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "isimp/core/job.h"

namespace isimp::detail {

using Vec2 = Eigen::Vector2d;

/// Twice the area of a triangle, positive if it runs counter-clockwise.
inline double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Some points of a plane, in boxes of eight, and these in boxes of eight: finds the points in a triangle, and allows
/// the removal of single points.
class PointBoxes {
 public:
  /// \param points  numbers of the points in `place`, each once.
  /// Cost: O(points); polled.
  void build(const std::vector<Vec2>& place, const std::vector<std::int32_t>& points, Job& job);
  /// Removes the point of this number, which is in here.
  void remove(std::int32_t point);

  /// Calls test(point) for each of the points near a triangle a, b, c that runs counter-clockwise, including all points
  /// inside, until it returns true.
  /// \param step  called once for every visited box and point
  /// \return whether it returned true
  template <class Test, class Step>
  bool any_near(const std::array<Vec2, 3>& triangle, Test test, Step step) const {
    if (levels_.empty()) return false;
    const Triangle2 near(triangle, farthest_);
    std::array<std::pair<int, std::int32_t>, 128> open;  // at most 8 of each level, and 11 levels hold all
    std::size_t count = 0;
    open[count++] = {static_cast<int>(levels_.size()) - 1, 0};
    while (count > 0) {
      const auto [level, k] = open[--count];
      const Node& node = levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(k)];
      step();
      if (node.count == 0 || near.misses(node)) continue;
      const std::size_t below = level == 0 ? points_.size() : levels_[static_cast<std::size_t>(level) - 1].size();
      const std::size_t first = static_cast<std::size_t>(k) * kBranches, last = std::min(below, first + kBranches);
      for (std::size_t child = first; child < last; ++child) {
        if (level > 0) {
          open[count++] = {level - 1, static_cast<std::int32_t>(child)};
        } else if (const std::int32_t point = points_[child]; point >= 0) {
          step();
          if (test(point)) return true;
        }
      }
    }
    return false;
  }

 private:
  static constexpr std::int32_t kBranches = 8;  // work
  struct Node {
    double left, right, low, high;
    std::int32_t count;  // number of points in it
  };
  /// A triangle prepared for comparison with boxes; cases that rounding might hide count as near.
  class Triangle2 {
   public:
    Triangle2(const std::array<Vec2, 3>& corners, double farthest);
    [[nodiscard]] bool misses(const Node& box) const;

   private:
    std::array<Vec2, 3> corners_;
    double margin_, left_, right_, low_, high_;
  };

  void sort(const std::vector<Vec2>& place, Job& job);
  void make_levels(const std::vector<Vec2>& place);

  std::vector<std::int32_t> points_, slot_;  // near ones in a row, -1 where removed; the place of each point
  std::vector<std::vector<Node>> levels_;
  double farthest_ = 0.0;  // largest coordinate of all points in the plane
};

}  // namespace isimp::detail
