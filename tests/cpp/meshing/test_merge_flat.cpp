// Coplanar faces as polygons, with nothing else changed.
#include "isimp/meshing/merge_flat.h"
#include "tests.h"

namespace isimp {
namespace {

FlatMerge merged(const Mesh& mesh, double angle = kFlatAngle, std::span<const std::int32_t> group = {}) {
  return merge_flat(mesh, angle, group, job());
}

double area(const PolygonMesh& mesh) {
  double sum = 0;
  for (std::int32_t q = 0; q < mesh.polygon_count(); ++q) {
    Vec3 normal = Vec3::Zero();
    for (std::int32_t i = mesh.loop_start[q]; i < mesh.loop_end(q); ++i) {
      const std::int32_t next = i + 1 < mesh.loop_end(q) ? i + 1 : mesh.loop_start[q];
      const Vec3 &a = mesh.vertices[mesh.loops[i]], &b = mesh.vertices[mesh.loops[next]];
      normal += Vec3(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()) / 2;
    }
    sum += normal.norm();
  }
  return sum;
}

/// Whether no polygon names a vertex twice, and vertices are some of the mesh's, unmoved.
bool is_clean(const Mesh& mesh, const PolygonMesh& made) {
  for (std::int32_t q = 0; q < made.polygon_count(); ++q) {
    const std::set<std::int32_t> corners(made.loops.begin() + made.loop_start[q],
                                         made.loops.begin() + made.loop_end(q));
    if (static_cast<std::int32_t>(corners.size()) != made.loop_end(q) - made.loop_start[q] || corners.size() < 3)
      return false;
  }
  for (std::size_t w = 0; w < made.vertices.size(); ++w) {
    if (made.vertices[w] != Vec3(mesh.vertices()[made.source_vertex[w]] + mesh.origin())) return false;
  }
  return made.report.manifold;
}

TEST(MergeFlat, ACubeHasItsSixSidesAndEightCorners) {
  for (const int n : {1, 7}) {
    const Mesh mesh = shapes::mesh(shapes::cube(n));
    const PolygonMesh made = merged(mesh).polygons;
    EXPECT_EQ(made.polygon_count(), 6);
    EXPECT_EQ(made.vertices.size(), 8U);
    EXPECT_EQ(made.loops.size(), 24U);
    EXPECT_TRUE(made.report.closed);
    EXPECT_TRUE(is_clean(mesh, made));
    EXPECT_EQ(made.report.euler, 2);
  }
}

TEST(MergeFlat, ASphereStaysAsItIs) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const PolygonMesh made = merged(mesh).polygons;
  EXPECT_EQ(made.polygon_count(), mesh.face_count());
  EXPECT_EQ(static_cast<std::int32_t>(made.vertices.size()), mesh.vertex_count());
}

TEST(MergeFlat, AnAngleMergesWhatBendsLess) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const PolygonMesh made = merged(mesh, 20).polygons;
  EXPECT_LT(made.polygon_count(), mesh.face_count() / 3);
  EXPECT_TRUE(made.report.closed);
  EXPECT_TRUE(is_clean(mesh, made));
  EXPECT_EQ(made.report.euler, 2);
}

TEST(MergeFlat, HolesAreCutAndTopologyStays) {
  const auto is_open = [](int x, int y) { return x % 2 == 1 && y % 2 == 1; };
  const Mesh mesh = shapes::mesh(shapes::perforated(7, 5, 0.5, is_open));
  const FlatMerge found = merged(mesh);
  const PolygonMesh& made = found.polygons;
  EXPECT_TRUE(made.report.closed);
  EXPECT_TRUE(is_clean(mesh, made));
  EXPECT_EQ(made.report.euler, mesh.report().euler);
  EXPECT_EQ(made.report.euler, 2 - 2 * 6);  // a hole is a handle
  EXPECT_EQ(made.report.regions, 2 + 4 + 6 * 4);
  EXPECT_EQ(made.report.regions_split, 2);
  EXPECT_LE(made.polygon_count(), made.report.regions + 2 * 2 * 6);  // a hole costs two cuts at most
  EXPECT_EQ(made.vertices.size(), 8U + 6 * 8);
  double before = 0;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 a = mesh.vertices()[t[1]] - mesh.vertices()[t[0]], b = mesh.vertices()[t[2]] - mesh.vertices()[t[0]];
    before +=
        Vec3(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()).norm() / 2;
  }
  EXPECT_NEAR(area(made), before, 1e-9 * before);
}

TEST(MergeFlat, GroupsStayApart) {
  const Mesh mesh = shapes::mesh(shapes::plane(4));
  std::vector<std::int32_t> group(mesh.face_count(), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    group[f] = mesh.vertices()[mesh.triangles()[f][0]].x() + mesh.vertices()[mesh.triangles()[f][1]].x() +
                           mesh.vertices()[mesh.triangles()[f][2]].x() <
                       1.5
                   ? 0
                   : 1;
  }
  EXPECT_EQ(merged(mesh).polygons.polygon_count(), 1);
  const PolygonMesh made = merged(mesh, kFlatAngle, group).polygons;
  EXPECT_EQ(made.polygon_count(), 2);
  EXPECT_EQ(made.loops.size(), 8U);
  EXPECT_FALSE(made.report.closed);
}

TEST(MergeFlat, FarFromZeroNothingMoves) {
  const shapes::Arrays cube = shapes::moved(shapes::cube(5), {4.6e6, 5.3e5, 120});
  const Mesh mesh = shapes::mesh(cube);
  const PolygonMesh made = merged(mesh).polygons;
  EXPECT_EQ(made.polygon_count(), 6);
  for (std::size_t w = 0; w < made.vertices.size(); ++w)
    EXPECT_EQ(made.vertices[w], cube.vertices[made.source_vertex[w]]);
}

TEST(MergeFlat, AnAngleOutOfItsRangeAndWrongGroupsAreRefused) {
  const Mesh mesh = shapes::mesh(shapes::cube());
  EXPECT_THROW(merged(mesh, -1), InvalidInput);
  EXPECT_THROW(merged(mesh, 91), InvalidInput);
  const std::vector<std::int32_t> group(3, 0);
  EXPECT_THROW(merged(mesh, 1, group), InvalidInput);
}

TEST(MergeFlat, FuzzedScansStaySound) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const shapes::Arrays noisy = shapes::noisy(shapes::cube(6), 0.01 * (seed % 4), seed);
    const Mesh mesh = shapes::mesh(shapes::shuffled(noisy, seed));
    const PolygonMesh made = merged(mesh, seed % 3 == 0 ? 15.0 : 3.0).polygons;
    EXPECT_TRUE(made.report.closed) << seed;
    EXPECT_TRUE(is_clean(mesh, made)) << seed;
    EXPECT_EQ(made.report.euler, 2) << seed;
  }
}

}  // namespace
}  // namespace isimp
