// Meshes far from zero: the result is the result at zero, moved.
#include "isimp/interact/merge.h"
#include "isimp/mesh/clean.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/simplify/partitioner.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::moved;

const Vec3 kUtm(500000, 4600000, 128), kEcef(4000000, 600000, 4900000), kFar(50000000, 50000000, 50000000);

/// A rough sphere of diameter 2 whose coordinates stay exact when it is moved by whole numbers.
shapes::Arrays rough_sphere() {
  shapes::Arrays a = shapes::noisy(shapes::sphere(4), 0.01, 3);
  for (Vec3& v : a.vertices)
    for (int k = 0; k < 3; ++k) v[k] = std::round(v[k] * 0x1p20) * 0x1p-20;
  return a;
}

class Offsets : public testing::TestWithParam<Vec3> {};

TEST_P(Offsets, ShiftIsExact) {
  const shapes::Arrays far = moved(rough_sphere(), GetParam());
  const Mesh mesh = shapes::mesh(far);
  EXPECT_EQ(mesh.origin(), GetParam());
  for (std::size_t v = 0; v < far.vertices.size(); ++v) {
    ASSERT_EQ(mesh.vertices()[v] + mesh.origin(), far.vertices[v]) << v;
    ASSERT_LE(mesh.vertices()[v].cwiseAbs().maxCoeff(), 2) << v;
  }
  EXPECT_EQ(clean(far.vertices, far.triangles, {}, job()).origin(), GetParam());
}

TEST_P(Offsets, PolygonsEqualThoseAtZeroAfterAShift) {
  const shapes::Arrays here = rough_sphere();
  const Mesh mesh = shapes::mesh(here), far = shapes::mesh(moved(here, GetParam()));
  const Partition part = partition(mesh, {.proxies = 60}, job()), far_part = partition(far, {.proxies = 60}, job());
  EXPECT_EQ(part.face_region, far_part.face_region);
  const PolygonMesh p = polygonize(mesh, part, {}, job()), q = polygonize(far, far_part, {}, job());
  EXPECT_EQ(p.loops, q.loops);
  EXPECT_EQ(p.report, q.report);
  ASSERT_EQ(p.vertices.size(), q.vertices.size());
  for (std::size_t v = 0; v < p.vertices.size(); ++v)
    ASSERT_LE((q.vertices[v] - GetParam() - p.vertices[v]).norm(), 1e-7) << v;
}

TEST_P(Offsets, LinesToCutAlongAreInTheCallersCoordinates) {
  const Mesh mesh = shapes::mesh(moved(shapes::plane(8), GetParam()));
  const std::vector<Vec3> line{GetParam() + Vec3(0.5, 0, 0), GetParam() + Vec3(0.5, 1, 0)};
  const Partition two = split_along(mesh, partition(mesh, {.proxies = 1}, job()), 0, line, Vec3(0, 0, 1), job());
  ASSERT_EQ(two.region_count(), 2);
  EXPECT_EQ(two.region_sum[0].faces, 64);
  EXPECT_EQ(two.region_sum[1].faces, 64);
}

INSTANTIATE_TEST_SUITE_P(Maps, Offsets, testing::Values(kUtm, kEcef, kFar, Vec3(-kUtm)));

TEST(MapCoordinates, NearZeroNothingIsShifted) {
  EXPECT_EQ(shapes::mesh(shapes::cube(2)).origin(), Vec3::Zero());
  EXPECT_EQ(shapes::mesh(moved(shapes::cube(2), Vec3(2, -2, 0.3))).origin(), Vec3::Zero());
}

TEST(MapCoordinates, OnlyAxesThatAreFarAreShifted) {
  const Mesh mesh = shapes::mesh(moved(shapes::cube(2), Vec3(1 << 20, 0.3, 0)));
  EXPECT_NEAR(mesh.origin().x(), 1 << 20, 1);
  EXPECT_EQ(mesh.origin().tail<2>(), Eigen::Vector2d::Zero());
}

TEST(MapCoordinates, RoughScansOfFewMetresAreAsGoodAsAtZero) {
  // Coordinates that are not exact far from zero: a scan of 5 units at steps of up to 7e-9.
  for (const Vec3& by : {Vec3(5e5, 4.6e6, 100), Vec3(4e6, 6e5, 4.9e6), Vec3(5e7, 5e7, 5e7)}) {
    shapes::Arrays a = shapes::noisy(shapes::smoothed(shapes::cube(12), 2), 0.002, 5);
    for (Vec3& v : a.vertices) v = 3 * v + by;
    const Mesh mesh = shapes::mesh(a);
    const PolygonMesh p = polygonize(mesh, partition(mesh, {.proxies = 300}, job()), {}, job());
    EXPECT_TRUE(p.report.imperfect.empty());
    EXPECT_LE(p.report.polygons, 306);
    EXPECT_LE((p.vertices[0] - by).norm(), 6);
  }
}

}  // namespace
}  // namespace isimp
