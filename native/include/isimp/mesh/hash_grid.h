#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/types.h"

namespace isimp::detail {

/// Points by the cells of a grid, in a hash table: finds points within a distance, the width of a cell. A point with NaN
/// is near no other.
/// Cost: O(1) a point if few share a cell.
class HashGrid {
 public:
  /// \param expected  about how many points will be kept
  /// \param reach     0: equal positions only; zeros of either sign are equal
  HashGrid(std::size_t expected, double reach) : reach_(reach), heads_(std::bit_ceil(2 * expected + 1), kNone) {}

  void keep(const Vec3& place, std::int32_t point) {
    std::int32_t& head = heads_[slot(cell(place))];
    entries_.push_back({point, head});
    head = static_cast<std::int32_t>(entries_.size()) - 1;
  }
  /// Calls fn(point) for all kept points within reach of a place, and for some others; a point may be repeated.
  template <class Function>
  void for_each_near(const Vec3& place, Function fn) const {
    const Vec3 home = cell(place);
    const int most = reach_ > 0 ? 1 : 0;
    for (int i = -most; i <= most; ++i)
      for (int j = -most; j <= most; ++j)
        for (int k = -most; k <= most; ++k)
          for (std::int32_t e = heads_[slot(home + Vec3(i, j, k))]; e != kNone; e = entries_[e].next)
            fn(entries_[e].point);
  }
  struct Nearest {
    std::int32_t point;
    double distance;
  };
  /// The nearest kept point within reach, the lowest of equally near ones; kNone if there is none.
  /// \param points  the places of all points
  [[nodiscard]] Nearest nearest(std::span<const Vec3> points, const Vec3& place) const {
    Nearest best{kNone, reach_};
    for_each_near(place, [&](std::int32_t other) {
      const double distance = (points[other] - place).norm();
      const bool tie = distance == best.distance && (best.point == kNone || other < best.point);
      if (distance < best.distance || tie) best = {other, distance};
    });
    return best;
  }
  /// Returns the nearest point, or keeps `place` by its index `fresh` and returns kNone.
  std::int32_t find_or_keep(std::span<const Vec3> points, const Vec3& place, std::int32_t fresh) {
    const std::int32_t found = nearest(points, place).point;
    if (found == kNone) keep(place, fresh);
    return found;
  }

 private:
  struct Entry {
    std::int32_t point, next;  // next of the same cell
  };
  [[nodiscard]] Vec3 cell(const Vec3& p) const {
    if (reach_ == 0) return p;
    return {cell(p.x()), cell(p.y()), cell(p.z())};
  }
  /// A coordinate that is too large for its cell to be a number differs from all others by more than the reach.
  [[nodiscard]] double cell(double x) const {
    const double at = std::floor(x / reach_);
    return std::isfinite(at) ? at : x;
  }
  [[nodiscard]] std::size_t slot(const Vec3& cell) const {
    std::uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(cell[k] + 0.0)) * 0x9e3779b97f4a7c15ULL;  // + 0.0 makes -0 into 0
      hash ^= hash >> 32;
    }
    return hash & (heads_.size() - 1);
  }

  double reach_;
  std::vector<std::int32_t> heads_;
  std::vector<Entry> entries_;
};

}  // namespace isimp::detail
