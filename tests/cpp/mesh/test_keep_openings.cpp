// Openings that stay open because the caller names a place in them.
#include "isimp/mesh/found_opening.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::Arrays;

Cleaned cleaned(const Arrays& a, const std::vector<Vec3>& keep, double length) {
  return clean_keeping(a.vertices, a.triangles, {.fill_holes = length, .cut_handles = length}, keep, job());
}

/// A sphere with holes of a length of about 1 at +z, -z, +x and -x.
Arrays pierced() {
  Arrays a = shapes::sphere(4);
  std::vector<Triangle> kept;
  for (const Triangle& t : a.triangles) {
    const Vec3 c = (a.vertices[t[0]] + a.vertices[t[1]] + a.vertices[t[2]]) / 3;
    if (std::abs(c.z()) < 0.985 && std::abs(c.x()) < 0.985) kept.push_back(t);
  }
  a.triangles = kept;
  return a;
}

/// Two thin rings next to each other: handles of a loop of .8 around each tube and 3 through each hole.
Arrays rings(double apart) {
  return shapes::both(shapes::torus(48, 12, 0.12), shapes::torus(48, 12, 0.12), {apart, 0, 0});
}

TEST(KeepOpenings, ClosedOpeningsAreListed) {
  const Cleaned all = cleaned(pierced(), {}, 2);
  ASSERT_EQ(all.openings.size(), 4U);
  EXPECT_TRUE(all.mesh.report().closed);
  Vec3 sum = Vec3::Zero();
  for (const FoundOpening& o : all.openings) {
    EXPECT_FALSE(o.handle);
    EXPECT_FALSE(o.kept);
    EXPECT_NEAR(o.center.norm(), 0.985, 0.03) << "at the hole";
    ASSERT_EQ(o.loops.size(), 1U);
    EXPECT_GT(o.loops[0].size(), 5U);
    sum += o.center;
  }
  EXPECT_LT(sum.norm(), 0.05) << "one on each side";
}

TEST(KeepOpenings, AHoleStaysAndTheOthersAreClosed) {
  const Arrays scan = pierced();
  for (const FoundOpening& one : cleaned(scan, {}, 2).openings) {
    const Cleaned rest = cleaned(scan, {one.center}, 2);
    EXPECT_EQ(rest.mesh.report().border_loops, 1);
    ASSERT_EQ(rest.openings.size(), 4U);
    int kept = 0;
    for (const FoundOpening& o : rest.openings) {
      kept += o.kept ? 1 : 0;
      EXPECT_EQ(o.kept, (o.center - one.center).norm() < 1e-9);
    }
    EXPECT_EQ(kept, 1);
  }
}

TEST(KeepOpenings, ThePlaceNeedNotBeExact) {
  EXPECT_EQ(cleaned(pierced(), {{0.1, 0, 1}}, 2).mesh.report().border_loops, 1);
  EXPECT_EQ(cleaned(pierced(), {{0.1, 0, 0}}, 2).mesh.report().border_loops, 0) << "too far from all";
}

TEST(KeepOpenings, TheSameStaysAfterVerticesAreRenumberedAndTheLengthIsAnother) {
  const Arrays scan = pierced();
  const Vec3 place = cleaned(scan, {}, 2).openings[1].center;
  Arrays other = scan;
  const auto n = static_cast<std::int32_t>(scan.vertices.size());
  std::reverse(other.vertices.begin(), other.vertices.end());
  std::reverse(other.triangles.begin(), other.triangles.end());
  for (Triangle& t : other.triangles)
    for (std::int32_t& v : t) v = n - 1 - v;
  const Cleaned rest = cleaned(other, {place}, 3);
  int kept = 0;
  for (const FoundOpening& o : rest.openings)
    if (o.kept) {
      ++kept;
      EXPECT_LT((o.center - place).norm(), 1e-9);
    }
  EXPECT_EQ(kept, 1);
}

TEST(KeepOpenings, OneHandleOfTwoStays) {
  const Arrays scan = rings(3);
  const Cleaned all = cleaned(scan, {}, 1);
  ASSERT_EQ(all.openings.size(), 2U);
  EXPECT_EQ(all.mesh.report().euler, 4);
  for (const FoundOpening& one : all.openings) {
    EXPECT_TRUE(one.handle);
    EXPECT_EQ(one.loops.size(), 2U);
    for (const double length : {1.0, 1.5}) {
      const Cleaned rest = cleaned(scan, {one.center}, length);
      EXPECT_EQ(rest.mesh.report().euler, 2) << "one handle is left";
      ASSERT_EQ(rest.openings.size(), 2U);
      EXPECT_NE(rest.openings[0].kept, rest.openings[1].kept);
    }
  }
}

TEST(KeepOpenings, NoOtherLoopClosesAHandleThatStays) {
  // Loops around the tube and loops through the hole are all short enough; the shortest one is listed.
  const Arrays ring = shapes::torus(48, 24, 0.4);
  const Cleaned all = cleaned(ring, {}, 10);
  ASSERT_EQ(all.openings.size(), 1U);
  const Cleaned rest = cleaned(ring, {all.openings[0].center}, 10);
  EXPECT_EQ(rest.mesh.report().euler, 0);
  ASSERT_EQ(rest.openings.size(), 1U);
  EXPECT_TRUE(rest.openings[0].kept);
}

TEST(KeepOpenings, WithoutClosedOpeningsTheListIsEmpty) {
  const Arrays scan = pierced();
  const Cleaned open = clean_keeping(scan.vertices, scan.triangles, {}, {{0, 0, 1}}, job());
  EXPECT_TRUE(open.openings.empty());
  EXPECT_EQ(open.mesh.report().border_loops, 4);
}

TEST(KeepOpenings, PlacesAreChecked) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cleaned(pierced(), {{0, none, 0}}, 2), InvalidInput);
}

}  // namespace
}  // namespace isimp
