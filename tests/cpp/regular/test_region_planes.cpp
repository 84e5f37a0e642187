#include <gtest/gtest.h>

#include <vector>

#include "region_planes.h"

namespace isimp::regular {
namespace {

/// A region whose faces are this far from its plane.
RegionPlane rough(double area, double distance) {
  RegionPlane region;
  region.scan.area = area;
  region.scan.centre = {1, 2, 3};
  region.scan.spread = Vec3(9, 4, distance * distance).asDiagonal();
  return region;
}

TEST(RegionPlanes, TheMedianDistanceIsThatOfHalfOfTheArea) {
  EXPECT_EQ(median_distance({}), 0);
  EXPECT_DOUBLE_EQ(median_distance({rough(4, 0.3), rough(2, 0.1), rough(1, 0.2)}), 0.3);
  EXPECT_DOUBLE_EQ(median_distance({rough(2, 0.3), rough(2, 0.1), rough(1, 0.2)}), 0.2);
  EXPECT_DOUBLE_EQ(median_distance({rough(2, 0.3), rough(9, 0.1), rough(1, 0.2)}), 0.1);
}

}  // namespace
}  // namespace isimp::regular
