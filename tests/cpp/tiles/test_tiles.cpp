#include "isimp/tiles/thin.h"
#include "isimp/tiles/weld.h"
#include "tests.h"

namespace isimp {
namespace {

Vec3 vector_area(std::span<const Vec3> p, const Triangle& t) {
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
}

/// Six times the volume of a closed surface.
double volume(std::span<const Vec3> p, std::span<const Triangle> triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) sum += p[t[0]].dot(p[t[1]].cross(p[t[2]]));
  return sum;
}

TEST(Thinning, LeavesAsManyFacesAsRequestedAndTheShape) {
  const Mesh mesh = shapes::mesh(shapes::cube(20));
  const tiles::Thinned thinned = tiles::thin(mesh, 1200, job());
  EXPECT_EQ(thinned.triangles.size(), 1200U);
  const Mesh checked(thinned.vertices, thinned.triangles, job());
  EXPECT_TRUE(checked.report().closed);
  EXPECT_NEAR(volume(checked.vertices(), checked.triangles()), volume(mesh.vertices(), mesh.triangles()), 1e-9);
  EXPECT_EQ(tiles::thin(mesh, mesh.face_count(), job()).triangles.size(), static_cast<std::size_t>(mesh.face_count()));
}

TEST(Thinning, KeepsEdgesAndCornersOfACube) {
  const Mesh mesh = shapes::mesh(shapes::cube(20));
  const tiles::Thinned thinned = tiles::thin(mesh, 300, job());
  EXPECT_LE(thinned.triangles.size(), 300U);
  EXPECT_NEAR(volume(thinned.vertices, thinned.triangles), volume(mesh.vertices(), mesh.triangles()), 1e-9);
}

TEST(Thinning, TurnsNoFaceOverOnANoisySurface) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::plane(40), 0.002, 3));
  const tiles::Thinned thinned = tiles::thin(mesh, mesh.face_count() / 4, job());
  EXPECT_LE(thinned.triangles.size(), static_cast<std::size_t>(mesh.face_count()) / 3);
  for (const Triangle& t : thinned.triangles) EXPECT_GT(vector_area(thinned.vertices, t).z(), 0);
}

TEST(Thinning, KeepsTheBorder) {
  const Mesh mesh = shapes::mesh(shapes::both(shapes::plane(8), shapes::plane(2), {3, 0, 0}));
  const tiles::Thinned thinned = tiles::thin(mesh, 0, job());
  const Mesh checked(thinned.vertices, thinned.triangles, job());
  EXPECT_EQ(checked.report().border_edges, 40);
  EXPECT_EQ(checked.component_count(), 2);
  EXPECT_LT(checked.face_count(), mesh.face_count() / 2);
}

TEST(Thinning, EachFaceIsPartOfAFaceNearby) {
  constexpr int kSquares = 24;
  const Mesh mesh = shapes::mesh(shapes::cube(kSquares));
  const tiles::Thinned thinned = tiles::thin(mesh, mesh.face_count() / 4, job());
  ASSERT_EQ(thinned.face.size(), static_cast<std::size_t>(mesh.face_count()));
  EXPECT_EQ(std::set(thinned.face.begin(), thinned.face.end()).size(), thinned.triangles.size());
  const std::vector<Vec3> p(mesh.vertices().begin(), mesh.vertices().end());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3 own = vector_area(p, mesh.triangles()[f]);
    const Vec3 to = vector_area(thinned.vertices, thinned.triangles[thinned.face[f]]);
    EXPECT_GT(own.dot(to), 0.99 * own.norm() * to.norm()) << "face " << f << " is part of a face of another side";
  }
}

TEST(Thinning, EndsWhereTheShapeWouldBeLost) {
  const Mesh mesh = shapes::mesh(shapes::sphere(4));
  const tiles::Thinned thinned = tiles::thin(mesh, 0, job());
  const Mesh checked(thinned.vertices, thinned.triangles, job());
  EXPECT_TRUE(checked.report().closed);
  EXPECT_GT(volume(checked.vertices(), checked.triangles()), 0.5 * volume(mesh.vertices(), mesh.triangles()));
}

TEST(Thinning, MayBeCancelled) {
  Job job;
  job.cancel();
  EXPECT_THROW(tiles::thin(shapes::mesh(shapes::plane(8)), 10, job), Cancelled);
}

TEST(Welding, TakesTheNearestPlaceOfAnEarlierTile) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {1.00015, 0, 0}, {0.0001, 0, 0}, {0.0002, 0, 0}, {2, 0, 0}};
  const std::vector<std::int32_t> tile = {0, 0, 1, 1, 1, 2};
  EXPECT_EQ(tiles::weld(points, tile, 1e-3, job()), (std::vector<std::int32_t>{0, 1, 1, 0, 4, 5}));
  EXPECT_EQ(tiles::weld(points, tile, 1e-5, job()), (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_THROW(tiles::weld(points, tile, 0, job()), InvalidInput);
  EXPECT_THROW(tiles::weld(points, std::vector<std::int32_t>{1, 0, 0, 0, 0, 0}, 1, job()), InvalidInput);
}

TEST(Welding, WorksInMapCoordinates) {
  const Vec3 far(5e5, 5e6, 100);
  const std::vector<Vec3> points = {far, far + Vec3(1e-4, 0, 0), far + Vec3(1, 0, 0)};
  EXPECT_EQ(tiles::weld(points, std::vector<std::int32_t>{0, 1, 1}, 1e-3, job()), (std::vector<std::int32_t>{0, 0, 2}));
}

TEST(Welding, FindsPointsInsideEdgesInTheirOrder) {
  const std::vector<Vec3> ends = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 9}};
  const std::vector<Vec3> points = {{0.75, 0, 0}, {0.25, 1e-7, 0}, {1, 0, 0}, {0.5, 0.1, 0}, {0, 1, 6}};
  const auto found = tiles::points_on_edges(ends, points, 1e-6, job());
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].point, 1);
  EXPECT_EQ(found[1].point, 0);
  EXPECT_EQ(found[2].edge, 1);
  EXPECT_EQ(found[2].point, 4);
  EXPECT_NEAR(found[2].along, 2.0 / 3, 1e-12);
}

}  // namespace
}  // namespace isimp
