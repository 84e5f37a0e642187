// Results of `meet_elsewhere` for two triangles that share none, one, two or three vertices.
#include <gtest/gtest.h>

#include "isimp/mesh/meet.h"

namespace isimp {
namespace {

constexpr Triangle kOne = {0, 1, 2};
const Corners kFlat = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};

TEST(Meet, ATriangleOnALineHasNoArea) {
  EXPECT_TRUE(has_area(kFlat));
  EXPECT_FALSE(has_area({Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(3, 3, 3)}));
  EXPECT_TRUE(has_area({Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(3, 3, 3 + 1e-15)}));  // exact: there is no tolerance
}

TEST(Meet, WithoutAVertexInCommonTouchingIsMeeting) {
  EXPECT_TRUE(meet_elsewhere(kOne, kFlat, {3, 4, 5}, {Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(5, 5, 1)}));
  EXPECT_TRUE(meet_elsewhere(kOne, kFlat, {3, 4, 5}, {Vec3(0, 0, 0), Vec3(-1, 0, 1), Vec3(0, -1, 1)}));
  EXPECT_FALSE(meet_elsewhere(kOne, kFlat, {3, 4, 5}, {Vec3(0, 0, 1e-9), Vec3(-1, 0, 1), Vec3(0, -1, 1)}));
}

TEST(Meet, ASharedVertexIsNoMeetingButPointsBeyondItAre) {
  EXPECT_FALSE(meet_elsewhere(kOne, kFlat, {3, 0, 4}, {Vec3(-1, 0, 1), Vec3(0, 0, 0), Vec3(0, -1, 1)}));
  // Its side opposite the vertex passes through the other one.
  EXPECT_TRUE(meet_elsewhere(kOne, kFlat, {3, 0, 4}, {Vec3(1, 1, -1), Vec3(0, 0, 0), Vec3(1, 1, 1)}));
  EXPECT_TRUE(meet_elsewhere({3, 0, 4}, {Vec3(1, 1, -1), Vec3(0, 0, 0), Vec3(1, 1, 1)}, kOne, kFlat));
}

TEST(Meet, AcrossASharedEdgeOnlyAFoldIsMeeting) {
  EXPECT_FALSE(meet_elsewhere(kOne, kFlat, {1, 0, 3}, {kFlat[1], kFlat[0], Vec3(1, -3, 0)}));
  EXPECT_FALSE(meet_elsewhere(kOne, kFlat, {1, 0, 3}, {kFlat[1], kFlat[0], Vec3(1, 3, 1e-9)}));
  EXPECT_TRUE(meet_elsewhere(kOne, kFlat, {1, 0, 3}, {kFlat[1], kFlat[0], Vec3(1, 3, 0)}));
  EXPECT_TRUE(meet_elsewhere(kOne, kFlat, {3, 1, 0}, {Vec3(1, 3, 0), kFlat[1], kFlat[0]}));
}

TEST(Meet, TheSameThreeVerticesTwiceMeet) {
  EXPECT_TRUE(meet_elsewhere(kOne, kFlat, {2, 1, 0}, {kFlat[2], kFlat[1], kFlat[0]}));
}

}  // namespace
}  // namespace isimp
