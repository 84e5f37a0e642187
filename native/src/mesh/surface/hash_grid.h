#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "isimp/core/types.h"

namespace isimp::detail {

/// A hash grid: finds points within a distance of each other, by a hash of the cells of a grid of that width. A point
/// with NaN is near no other.
/// Cost: O(1) a point if few share a cell.
class HashGrid {
 public:
  /// \param points     may grow meanwhile
  /// \param expected   about how many points will be kept
  /// \param tolerance  0: equal positions only; zeros of either sign are equal
  HashGrid(const std::vector<Vec3>& points, std::size_t expected, double tolerance)
      : points_(points), tolerance_(tolerance), heads_(std::bit_ceil(2 * expected + 1), kNone) {}

  /// Returns the nearest stored point within the tolerance of `place`, the first of equally near ones. If there is none,
  /// stores `place` by its index `fresh` and returns kNone.
  std::int32_t find_or_keep(const Vec3& place, std::int32_t fresh) {
    const Vec3 home = cell(place);
    Nearest nearest{kNone, tolerance_};
    const int reach = tolerance_ > 0 ? 1 : 0;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j)
        for (int k = -reach; k <= reach; ++k) search(home + Vec3(i, j, k), place, nearest);
    if (nearest.point == kNone) {
      std::int32_t& head = heads_[slot(home)];
      next_.push_back(head);
      head = static_cast<std::int32_t>(kept_.size());
      kept_.push_back(fresh);
    }
    return nearest.point;
  }

 private:
  struct Nearest {
    std::int32_t point;
    double distance;
  };
  void search(const Vec3& cell, const Vec3& place, Nearest& nearest) const {
    for (std::int32_t e = heads_[slot(cell)]; e != kNone; e = next_[e]) {
      const std::int32_t other = kept_[e];
      const double distance = (points_[other] - place).norm();
      const bool tie = distance == nearest.distance && (nearest.point == kNone || other < nearest.point);
      if (distance < nearest.distance || tie) nearest = {other, distance};
    }
  }
  [[nodiscard]] Vec3 cell(const Vec3& p) const {
    if (tolerance_ == 0) return p;
    return {std::floor(p.x() / tolerance_), std::floor(p.y() / tolerance_), std::floor(p.z() / tolerance_)};
  }
  [[nodiscard]] std::size_t slot(const Vec3& cell) const {
    std::uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(cell[k] + 0.0)) * 0x9e3779b97f4a7c15ULL;  // + 0.0 makes -0 into 0
      hash ^= hash >> 32;
    }
    return hash & (heads_.size() - 1);
  }

  const std::vector<Vec3>& points_;
  double tolerance_;
  std::vector<std::int32_t> heads_, next_, kept_;
};

}  // namespace isimp::detail
