// The estimated number of polygons.
#include "isimp/meshing/expected.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"
#include "isimp/simplify/partitioner.h"
#include "tests.h"

namespace isimp {
namespace {

ExpectedPolygons foreseen(const Mesh& mesh, const Partition& part, const MeshingOptions& options = {}) {
  return expected_polygons(mesh, part, options, job());
}

Partition split(const Mesh& mesh, std::int32_t regions) {
  return Partitioner(mesh).run({.proxies = regions}, {}, job());
}

std::int32_t sum(const ExpectedPolygons& e) {
  return e.regions + e.split_for_unconnected + e.split_for_pinches + e.split_for_holes + e.split_for_handles +
         e.split_for_closed + e.split_for_repair;
}

TEST(ExpectedPolygons, OfACubeAreItsSides) {
  const Mesh mesh = shapes::mesh(shapes::cube());
  const ExpectedPolygons e = foreseen(mesh, split(mesh, 6));
  EXPECT_EQ(e.polygons, 6);
  EXPECT_EQ(e.regions, 6);
  EXPECT_EQ(e.split_for_repair, 0);
}

TEST(ExpectedPolygons, OfAWholeSphereAreThoseThatAClosedSurfaceNeeds) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const ExpectedPolygons e = foreseen(mesh, split(mesh, 4));
  EXPECT_GE(e.polygons, 4);
  EXPECT_EQ(e.polygons, sum(e));
}

TEST(ExpectedPolygons, AreWithinATenthOnARoughTorus) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(96, 48), 0.003, 1));
  for (const std::int32_t regions : {20, 60, 200}) {
    const Partition part = split(mesh, regions);
    const ExpectedPolygons e = foreseen(mesh, part);
    const std::int32_t made = polygonize(mesh, part, {}, job()).report.polygons;
    EXPECT_NEAR(e.polygons, made, 2 + 0.1 * made) << regions << " regions";
    EXPECT_EQ(e.polygons, sum(e));
  }
}

TEST(ExpectedPolygons, HolesAndHandlesOfRegionsAreNamed) {
  // One region all over a torus: the cuts that make discs of it are for its handle.
  const Mesh mesh = shapes::mesh(shapes::torus(24, 12));
  const Partition whole =
      partition_from(mesh, std::vector<std::int32_t>(static_cast<std::size_t>(mesh.face_count()), 0), job());
  const ExpectedPolygons e = foreseen(mesh, whole);
  EXPECT_EQ(e.regions, 1);
  EXPECT_GT(e.split_for_handles + e.split_for_holes + e.split_for_closed, 0);
  EXPECT_EQ(e.polygons, sum(e));
}

TEST(ExpectedPolygons, RefuseWhatPolygonizeRefuses) {
  const Mesh mesh = shapes::mesh(shapes::cube()), other = shapes::mesh(shapes::sphere(2));
  EXPECT_THROW(foreseen(other, split(mesh, 6)), InvalidInput);
  EXPECT_THROW(foreseen(mesh, split(mesh, 6), {.flatness = -1}), InvalidInput);
}

}  // namespace
}  // namespace isimp
