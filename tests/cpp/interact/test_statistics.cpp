// Figures of regions: area, distances, neighbours and sides.
#include <span>

#include "isimp/interact/statistics.h"
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::run;

TEST(Statistics, FitACube) {
  const Mesh mesh = shapes::mesh(shapes::cube(4));
  const Partition six = run(mesh, 6);
  for (const RegionStatistics& s : all_statistics(mesh, six, job())) {
    EXPECT_EQ(s.faces, 32);
    EXPECT_NEAR(s.area, 1.0, 1e-12);
    EXPECT_NEAR(s.distance_max, 0.0, 1e-12);
    EXPECT_EQ(s.neighbours.size(), 4U);
  }
}

TEST(Statistics, SidesFitTheRegions) {
  const shapes::Arrays cube = shapes::cube(4);
  const Mesh mesh = shapes::mesh(cube);
  const Partition six = run(mesh, 6);
  const std::vector<std::int32_t>& region = six.face_region;
  const RegionSides sides = region_sides(mesh.vertices(), mesh.triangles(), region, 7);
  ASSERT_EQ(sides.area.size(), 7U);
  ASSERT_EQ(sides.normal.size(), 7U);
  for (int r = 0; r < 6; ++r) {
    EXPECT_NEAR(sides.area[r], 1.0, 1e-12);
    EXPECT_NEAR((sides.normal[r] - six.region_normal[r]).norm(), 0.0, 1e-6);
  }
  EXPECT_EQ(sides.area[6], 0.0);  // no triangle is in it
  std::vector<Vec3> vertices(mesh.vertices().begin(), mesh.vertices().end());
  vertices[mesh.triangles()[0][1]].x() = std::nan("");
  const RegionSides torn = region_sides(vertices, mesh.triangles(), region, 6);
  EXPECT_TRUE(std::isfinite(torn.area[region[0]]));
  EXPECT_LT(torn.area[region[0]], 1.0);
  const std::vector<std::int32_t> none(region.size(), kNone);
  EXPECT_EQ(region_sides(mesh.vertices(), mesh.triangles(), none, 1).area[0], 0.0);
}

TEST(Statistics, SidesNameTheFault) {
  const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles{{0, 1, 2}, {0, 1, 3}};
  const auto said = [&](std::size_t count, std::vector<std::int32_t> region, std::int32_t regions) {
    return message_of([&] { region_sides(vertices, std::span(triangles).first(count), region, regions); });
  };
  EXPECT_EQ(said(1, {0, 0}, 1), "region must have 1 numbers, one for each triangle, got 2");
  EXPECT_EQ(said(1, {1}, 1), "region of triangle 0 must be in [-1, 1), got 1");
  EXPECT_EQ(said(1, {-2}, 1), "region of triangle 0 must be in [-1, 1), got -2");
  EXPECT_EQ(said(2, {0, 0}, 1), "triangle 1 has vertex 3, but there are 3 vertices");
  EXPECT_EQ(said(0, {}, -1), "regions must be at least 0, got -1");
}

TEST(Statistics, FitARoof) {
  shapes::Arrays roof = shapes::plane(2);  // folded up along its middle: a ridge of height .5 over
                                           // a square of base 1
  for (Vec3& v : roof.vertices) v.z() = 0.5 - std::abs(v.x() - 0.5);
  const Mesh mesh = shapes::mesh(roof);
  const RegionStatistics s = region_statistics(mesh, run(mesh, 1), 3, job());
  EXPECT_EQ(s.region, 0);
  EXPECT_NEAR(s.area, std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(s.distance_max, 0.25, 1e-6);  // the plane lies half-way up
  EXPECT_NEAR(s.distance_rms, 0.5 / std::sqrt(12.0), 1e-6);
  EXPECT_NEAR(s.error, std::sqrt(2.0) * (2 - std::sqrt(2.0)), 1e-6);
  EXPECT_TRUE(s.neighbours.empty());
}

}  // namespace
}  // namespace isimp
