#include "isimp/mesh/io.h"
#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "polygon_judge.h"
#include "tests.h"

namespace isimp {
namespace {

using labelled::meshed;

/// The numbers of polygons with 3, 4, ... corners.
std::vector<int> corner_counts(const PolygonMesh& p) {
  std::vector<int> counts;
  for (const judge::Loop& loop : judge::polygons_of(p)) counts.push_back(static_cast<int>(loop.size()));
  std::sort(counts.begin(), counts.end());
  return counts;
}

/// Whether there is a vertex within `tolerance` of each point, and no more vertices than points.
void expect_vertices(const PolygonMesh& p, const std::vector<Vec3>& points, double tolerance) {
  EXPECT_EQ(p.vertices.size(), points.size());
  for (const Vec3& at : points)
    EXPECT_TRUE(
        std::any_of(p.vertices.begin(), p.vertices.end(), [&](const Vec3& v) { return (v - at).norm() <= tolerance; }))
        << "no vertex at " << at.transpose();
}

std::vector<Vec3> box(const Vec3& low, const Vec3& high) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  return corners;
}

TEST(Polygonize, CubeComesBackAsSixQuadsInAnyFaceOrder) {
  for (std::uint32_t order = 0; order < 20; ++order) {
    const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::cube(8), order));
    const Partition sides = labelled::planes(mesh);
    ASSERT_EQ(sides.region_count(), 6);
    const PolygonMesh p = judge::sound(mesh, sides);
    EXPECT_EQ(corner_counts(p), std::vector<int>(6, 4));
    expect_vertices(p, box(Vec3::Zero(), Vec3::Ones()), 1e-12);
    EXPECT_LT(p.report.planarity_max, 1e-12);
  }
}

TEST(Polygonize, RotatedCubeIsExactToRounding) {
  for (std::uint32_t turn = 0; turn < 20; ++turn) {
    shapes::Arrays a = shapes::cube(6);
    const Eigen::AngleAxisd rotation(0.3 * turn, Vec3(1, 2.0 + turn, 3).normalized());
    std::vector<Vec3> corners = box(Vec3::Zero(), Vec3::Ones());
    for (Vec3& v : a.vertices) v = rotation * v;
    for (Vec3& v : corners) v = rotation * v;
    const Mesh mesh = shapes::mesh(shapes::shuffled(a, turn));
    const PolygonMesh p = meshed(mesh, labelled::planes(shapes::mesh(shapes::shuffled(shapes::cube(6), turn))));
    EXPECT_EQ(corner_counts(p), std::vector<int>(6, 4));
    expect_vertices(p, corners, 1e-9);
  }
}

TEST(Polygonize, TwoCubesAreTwelveQuads) {
  const Mesh mesh = shapes::mesh(shapes::both(shapes::cube(5), shapes::cube(3), {3, 0.5, 0.25}));
  const Partition sides = labelled::planes(mesh);
  const PolygonMesh p = judge::sound(mesh, sides);
  EXPECT_EQ(corner_counts(p).size(), 12U);
  EXPECT_TRUE(p.report.closed);
}

TEST(Polygonize, OneTriangleStaysOne) {
  const Mesh mesh = shapes::mesh({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  const PolygonMesh p = judge::sound(mesh, labelled::single(mesh));
  EXPECT_EQ(corner_counts(p), std::vector<int>{3});
  EXPECT_EQ(p.loops, (std::vector<std::int32_t>{0, 1, 2}));
}

TEST(Polygonize, OpenPlaneKeepsItsCornersAndArea) {
  const Mesh mesh = shapes::mesh(shapes::plane(12));
  const PolygonMesh whole = meshed(mesh, labelled::single(mesh));
  EXPECT_EQ(corner_counts(whole), std::vector<int>{4});
  expect_vertices(whole, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, 1e-12);
  for (const int regions : {2, 5, 20}) {
    const Partition parts = labelled::voronoi(mesh, regions, 5);
    const PolygonMesh p = judge::sound(mesh, parts);
    EXPECT_NEAR(judge::look_at(p).area, 1.0, 1e-9);
  }
}

TEST(Polygonize, AHalvedPlaneIsTwoRectangles) {
  const Mesh mesh = shapes::mesh(shapes::plane(10));
  const auto side = [](const Vec3& middle) { return middle.x() < 0.5 ? 0 : 1; };
  const PolygonMesh p = meshed(mesh, labelled::by(shapes::labels(mesh, side)));
  EXPECT_EQ(corner_counts(p), (std::vector<int>{4, 4}));
}

TEST(Polygonize, SphereOfOneRegionBecomesFourPolygons) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const Partition one = labelled::single(mesh);
  const PolygonMesh p = judge::sound(mesh, one);
  EXPECT_EQ(p.report.polygons, 4);
  EXPECT_EQ(p.report.regions, 1);
  EXPECT_EQ(p.report.regions_split, 1);
  EXPECT_EQ(p.report.split_for_closed, 3);
}

TEST(Polygonize, TorusOfOneRegionKeepsItsHandle) {
  const Mesh mesh = shapes::mesh(shapes::torus(40, 20));
  const Partition one = labelled::single(mesh);
  const PolygonMesh p = judge::sound(mesh, one);
  EXPECT_GT(p.report.split_for_handles, 0);
}

TEST(Polygonize, WhatMeetsInTheScanIsExcusedByName) {
  // Two cubes that intersect: three sides of one pass through three of the other.
  const Mesh mesh = shapes::mesh(shapes::both(shapes::cube(4), shapes::cube(4), {0.45, 0.3, 0.2}));
  const Partition sides = labelled::planes(mesh);
  const PolygonMesh p = meshed(mesh, sides);
  EXPECT_EQ(corner_counts(p), std::vector<int>(12, 4));
  EXPECT_EQ(p.report.intersecting, 0);
  EXPECT_EQ(p.report.excused, 6);
  ASSERT_EQ(p.report.imperfect.size(), 12U);
  EXPECT_TRUE(std::is_sorted(p.report.imperfect.begin(), p.report.imperfect.end()));
  for (const ListedDefect& i : p.report.imperfect) {
    EXPECT_EQ(i.kind, Defect::excused);
    const auto back = ListedDefect{i.other, Defect::excused, i.polygon};
    EXPECT_TRUE(std::binary_search(p.report.imperfect.begin(), p.report.imperfect.end(), back));
    const auto second = [&](std::int32_t q) { return p.polygon_region[q] >= 6; };
    EXPECT_NE(second(i.polygon), second(i.other));
  }
}

TEST(Polygonize, APartLeftOutGetsNoPolygon) {
  const Mesh mesh = shapes::mesh(shapes::both(shapes::cube(4), shapes::cube(1), {3, 0, 0}));
  Partition sides = labelled::planes(mesh);
  std::vector<std::int32_t> regions = sides.face_region;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (mesh.component()[f] == 1) regions[f] = kNone;
  const Partition kept = labelled::by(regions);
  const PolygonMesh p = judge::sound(mesh, kept);
  EXPECT_EQ(p.report.polygons, 6);
}

TEST(Polygonize, CornerCutByATriangle) {
  // A cube whose corner at the origin is a region of its own: a staircase of squares on each side.
  const Mesh mesh = shapes::mesh(shapes::cube(20));
  std::vector<std::int32_t> regions = labelled::planes(mesh).face_region;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (shapes::middle(mesh, f).sum() < 0.475) regions[f] = 6;
  const Partition cut = labelled::by(regions);
  const PolygonMesh p = judge::sound(mesh, cut);
  EXPECT_EQ(corner_counts(p), (std::vector<int>{3, 4, 4, 4, 5, 5, 5}));
}

TEST(Polygonize, UnconnectedRegionsBecomeConnectedPolygons) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  for (const int count : {2, 10, 1000}) {
    const Partition noise = labelled::noise(mesh, count, 11);
    const PolygonMesh p = judge::sound(mesh, noise);
  }
}

TEST(Polygonize, EveryFaceARegionGivesTheMeshBack) {
  const Mesh mesh = shapes::mesh(shapes::torus(15, 9));
  const PolygonMesh p = judge::sound(mesh, labelled::each(mesh));
  EXPECT_EQ(p.report.polygons, mesh.face_count());
  EXPECT_EQ(p.report.vertices, mesh.vertex_count());
}

TEST(Polygonize, ARegionWithoutAreaGoesToItsNeighbour) {
  // A unit square of two halves with a flat face between them; vertices 0, 2 and 4 lie on the diagonal.
  const Mesh mesh = shapes::mesh(
      {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}}, {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {4, 2, 3}}});
  const Partition each = labelled::each(mesh);
  const PolygonMesh p = judge::sound(mesh, each);
  EXPECT_EQ(p.report.merged_without_area, 1);
  EXPECT_EQ(p.report.polygons, 3);
  EXPECT_EQ(p.report.regions, 3);
}

TEST(Polygonize, NoCornerMovesFurtherThanTheReach) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.02, 3));
  const Partition parts = labelled::voronoi(mesh, 80, 2);
  for (const double reach : {0.0, 0.002, 0.01}) {
    const PolygonMesh p = meshed(mesh, parts, {.reach = reach});
    for (std::size_t i = 0; i < p.vertices.size(); ++i)
      EXPECT_LE((p.vertices[i] - mesh.vertices()[p.source_vertex[i]]).norm(), reach * mesh.diagonal() * (1 + 1e-9));
  }
}

double volume(const PolygonMesh& p) {
  double sum = 0;
  for (const judge::Loop& loop : judge::polygons_of(p))
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      sum += p.vertices[loop[0]].dot(p.vertices[loop[i]].cross(p.vertices[loop[i + 1]])) / 6;
  return sum;
}

TEST(Polygonize, PolygonsOfABulgeStayWhereTheScanIs) {
  const Mesh mesh = shapes::mesh(shapes::sphere(4));
  const PolygonMesh p = meshed(mesh, labelled::voronoi(mesh, 80, 2));
  EXPECT_NEAR(volume(p) / (4.0 / 3 * 3.14159265), 1.0, 0.05);
}

std::string said(const Mesh& mesh, const Partition& partition, const MeshingOptions& options = {}) {
  return message_of([&] { meshed(mesh, partition, options); });
}

TEST(Polygonize, BadInputIsNamed) {
  const Mesh mesh = shapes::mesh(shapes::cube(1));
  Partition p = labelled::single(mesh);
  p.face_region.pop_back();
  EXPECT_EQ(said(mesh, p), "the partition has 11 faces and the mesh has 12: it was made for another mesh");
  p = labelled::single(mesh);
  p.face_region[4] = 7;
  EXPECT_EQ(said(mesh, p), "face 4 is in region 7, but there are 1 regions");
  p = labelled::single(mesh);
  p.region_locked = {kLeftOut};
  EXPECT_EQ(said(mesh, p), "all regions are left out: there is nothing to make polygons of");
  EXPECT_EQ(said(mesh, labelled::single(mesh), {.reach = -1}), "reach must be in [0, 1], got -1");
}

/// The shapes of the data folder whose true regions are known.
class Known : public testing::TestWithParam<const char*> {};

TEST_P(Known, ComesBackExactly) {
  const std::string folder = labelled::data_folder();
  if (folder.empty()) GTEST_SKIP() << "no test data: set ISIMP_DATA";
  const std::string path = folder + "/known/" + GetParam();
  const PolygonSoup soup = read_polygons(path + ".ply", job());
  const Mesh mesh(soup.vertices, triangulate(soup, job()).triangles, job());
  const Partition truth = labelled::read_labels(path + ".lab");
  const PolygonMesh p = judge::sound(mesh, truth);
  EXPECT_NEAR(judge::look_at(p).area, mesh.report().area, 1e-6 * mesh.report().area);
  EXPECT_LT(p.report.planarity_max, 1e-6 * mesh.diagonal());
  EXPECT_LE(p.report.polygons, p.report.regions + 2 * p.report.regions_split);
}

INSTANTIATE_TEST_SUITE_P(Polygonize, Known,
                         testing::Values("cube12", "cube20", "cube20_rotated", "two_cubes", "lhouse", "washer",
                                         "plane_with_hole", "one_triangle"));

}  // namespace
}  // namespace isimp
