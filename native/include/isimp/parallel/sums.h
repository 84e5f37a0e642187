#pragma once

namespace isimp::parallel {

/// The sums of a region that fitting needs: its area, and area times normal, whose direction is the proxy's normal.
struct RegionSum {
  double area = 0;
  double x = 0, y = 0, z = 0;
  friend bool operator==(const RegionSum&, const RegionSum&) = default;
};

}  // namespace isimp::parallel
