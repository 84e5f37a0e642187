#include "isimp/meshing/expected.h"
#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "tests.h"

namespace isimp {
namespace {

using labelled::meshed;

/// The regions of `labelled::planes`, with normals and sums.
Partition planes_of(const Mesh& mesh) { return partition_from(mesh, labelled::planes(mesh).face_region, job()); }

/// A cube far from zero along one axis, its sides as regions, and the region that faces up.
struct Cube {
  Mesh mesh = [] {
    shapes::Arrays arrays = shapes::cube(6);
    for (Vec3& v : arrays.vertices) v.x() += 1000;
    return shapes::mesh(arrays);
  }();
  Partition sides = planes_of(mesh);
  std::int32_t top =
      static_cast<std::int32_t>(std::ranges::find_if(sides.region_normal, [](const Vec3& n) { return n.z() > 0.5; }) -
                                sides.region_normal.begin());

  [[nodiscard]] Partition without(std::vector<std::int32_t> regions) const {
    Partition part = sides;
    part.region_locked.assign(part.region_count(), 0);
    for (const std::int32_t r : regions) part.region_locked[r] = kLeftOut;
    return part;
  }
};

TEST(KeptPart, ARegionThatIsLeftOutIsABorder) {
  const Cube cube;
  const PolygonMesh p = meshed(cube.mesh, cube.without({cube.top}));
  EXPECT_EQ(p.polygon_count(), 5);
  EXPECT_EQ(p.vertices.size(), 8U);
  EXPECT_EQ(std::ranges::count(p.polygon_region, cube.top), 0);
  EXPECT_EQ(std::ranges::max(p.polygon_region), 5);
  EXPECT_FALSE(p.report.closed);
  EXPECT_TRUE(p.report.manifold);
  EXPECT_EQ(p.report.regions, 5);
  for (std::size_t k = 0; k < p.vertices.size(); ++k)
    EXPECT_LT((p.vertices[k] - cube.mesh.origin() - cube.mesh.vertices()[p.source_vertex[k]]).norm(), 1e-9);
}

TEST(KeptPart, FacesWithoutARegionAreLeftOutToo) {
  const Cube cube;
  Partition part = cube.sides;
  for (std::int32_t& r : part.face_region)
    if (r == cube.top) r = kNone;
  const PolygonMesh p = meshed(cube.mesh, part), same = meshed(cube.mesh, cube.without({cube.top}));
  EXPECT_EQ(p.vertices, same.vertices);
  EXPECT_EQ(p.loops, same.loops);
  EXPECT_EQ(p.polygon_region, same.polygon_region);
}

/// Opposite sides of a cube touch nowhere. Two neighbours that are kept share an edge.
TEST(KeptPart, SidesThatAreKeptNeedNotTouch) {
  const Cube cube;
  std::vector<std::int32_t> around;
  for (std::int32_t r = 0; r < 6; ++r)
    if (std::abs(cube.sides.region_normal[r].z()) < 0.5) around.push_back(r);
  const PolygonMesh p = meshed(cube.mesh, cube.without(around));
  EXPECT_EQ(p.polygon_count(), 2);
  EXPECT_EQ(p.vertices.size(), 8U);
  EXPECT_TRUE(p.report.manifold);
}

TEST(KeptPart, PlanesThatAreHeldStayInPlace) {
  const Cube cube;
  Partition part = cube.without({cube.top});
  part.region_held.assign(6, kPlaneByHand);
  part.region_offset.resize(6);
  for (std::int32_t r = 0; r < 6; ++r) {
    const std::int32_t vertex = cube.mesh.triangles()[part.region_seed[r]][0];
    const Vec3 place = cube.mesh.vertices()[vertex] + cube.mesh.origin();
    part.region_offset[r] = part.region_normal[r].dot(place) + 0.01;
  }
  const PolygonMesh p = meshed(cube.mesh, part);
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const Vec3& v : p.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  EXPECT_NEAR(low.x(), 999.99, 1e-6);
  EXPECT_NEAR(high.x(), 1001.01, 1e-6);
  EXPECT_NEAR(low.z(), -0.01, 1e-6);
}

TEST(KeptPart, CountsOfPolygonsAreOfWhatIsKept) {
  const Cube cube;
  EXPECT_EQ(expected_polygons(cube.mesh, cube.without({cube.top}), {}, job()).polygons, 5);
  EXPECT_EQ(expected_polygons(cube.mesh, cube.sides, {}, job()).polygons, 6);
}

TEST(KeptPart, ABoxReplacesRegionsThatAreTurnedAsTheyStand) {
  const shapes::Arrays floor = shapes::plane(8);
  shapes::Arrays arrays = shapes::cube(4);
  const Eigen::AngleAxisd turn(0.5, Vec3::UnitZ());
  for (Vec3& v : arrays.vertices) v = turn * v;
  const Mesh mesh = shapes::mesh(shapes::both(floor, arrays, {3, 0, 0}));
  Partition part = planes_of(mesh);
  part.region_locked.assign(part.region_count(), 0);
  const double wall = turn.toRotationMatrix().col(0).x();
  std::int32_t lowest = part.region_count();
  for (std::int32_t r = 0; r < part.region_count(); ++r)
    if (mesh.vertices()[mesh.triangles()[part.region_seed[r]][0]].x() > 1.5) {
      part.region_locked[r] = kBoxed;
      lowest = std::min(lowest, r);
    }
  const PolygonMesh p = meshed(mesh, part);
  ASSERT_EQ(p.polygon_count(), 1 + 6);
  EXPECT_EQ(p.report.boxes, 1);
  EXPECT_EQ(p.report.polygons, 7);
  EXPECT_TRUE(p.report.manifold);
  EXPECT_EQ(std::ranges::count(p.polygon_region, lowest), 6);
  double largest = 0, volume = 0;
  for (std::int32_t q = 1; q < 7; ++q) {
    const auto at = [&](int k) { return p.vertices[p.loops[p.loop_start[q] + k]]; };
    const Vec3 n = (at(1) - at(0)).cross(at(2) - at(0));
    EXPECT_NEAR(n.norm(), 1, 1e-9);
    largest = std::max(largest, n.x());
    volume += n.dot(at(0)) / 3;
  }
  EXPECT_NEAR(largest, wall, 1e-9);
  EXPECT_NEAR(volume, 1, 1e-9);
}

}  // namespace
}  // namespace isimp
