// Junctions that nearly coincide: where they become one, and where they must not.
#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "polygon_judge.h"
#include "tests.h"

namespace isimp {
namespace {

constexpr int kRows = 24;

/// A square of 24 by 24, bent to a saddle of this height, in four regions like bricks: the border between the lower two
/// is `shift` rows left of that between the upper two.
struct Bricks {
  Mesh mesh;
  Partition part;

  Bricks(double height, int shift) : mesh(bent(height)), part(labelled::by(labels(mesh, shift))) {}

  static Mesh bent(double height) {
    shapes::Arrays a = shapes::plane(kRows);
    for (Vec3& v : a.vertices) v.z() = height * (v.x() - 0.5) * (v.y() - 0.5);
    return shapes::mesh(a);
  }
  static std::vector<std::int32_t> labels(const Mesh& mesh, int shift) {
    return shapes::labels(mesh, [&](const Vec3& c) {
      const double middle = c.y() < 0.5 ? 0.5 - static_cast<double>(shift) / kRows : 0.5;
      return (c.y() < 0.5 ? 0 : 2) + (c.x() < middle ? 0 : 1);
    });
  }
  [[nodiscard]] PolygonMesh polygons(double join) const {
    return polygonize(mesh, part, {.join_junctions = join}, job());
  }
};

/// The largest number of polygons that meet in one vertex.
int most_round_a_vertex(const PolygonMesh& polygons) {
  std::vector<int> count(polygons.vertices.size(), 0);
  for (const std::int32_t v : polygons.loops) ++count[v];
  return *std::max_element(count.begin(), count.end());
}

TEST(Junctions, ThatNearlyCoincideBecomeOne) {
  for (const double height : {0.0, 0.2}) {
    const Bricks bricks(height, 2);
    const PolygonMesh before = bricks.polygons(0), after = bricks.polygons(0.8);
    EXPECT_EQ(most_round_a_vertex(before), 3);
    EXPECT_EQ(most_round_a_vertex(after), 4);
    EXPECT_EQ(before.polygon_count(), 4);
    EXPECT_EQ(after.polygon_count(), 4);
    EXPECT_EQ(after.vertices.size(), before.vertices.size() - 1);
    EXPECT_EQ(after.report.joined_junctions, 1);
    EXPECT_EQ(before.report.joined_junctions, 0);
    EXPECT_TRUE(after.report.imperfect.empty());
  }
}

TEST(Junctions, FarApartStay) {
  const Bricks bricks(0, 11);
  EXPECT_EQ(bricks.polygons(0.8).report.joined_junctions, 0);
}

TEST(Junctions, OfLockedRegionsStay) {
  // Faces would move from one region to another; with all but one locked there is no other.
  for (int free = 0; free < 4; ++free) {
    Bricks bricks(0, 2);
    bricks.part.region_locked = {1, 1, 1, 1};
    bricks.part.region_locked[free] = 0;
    EXPECT_EQ(bricks.polygons(0.8).report.joined_junctions, 0);
  }
}

TEST(Junctions, NeverCrossABarrier) {
  // Barriers along all borders: any join would move faces across one.
  const Mesh mesh = Bricks::bent(0);
  const std::vector<std::int32_t> labels = Bricks::labels(mesh, 2);
  Guides guides;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (const std::int32_t o = mesh.opposite(h); o > h && labels[h / 3] != labels[o / 3])
      guides.barriers.push_back({mesh.from(h), mesh.to(h)});
  const Partition free = partition_from(mesh, labels, job()),
                  kept = partition_from(Surface(mesh, guides, job()), labels, job());
  EXPECT_EQ(polygonize(mesh, free, {}, job()).report.joined_junctions, 1);
  EXPECT_EQ(polygonize(mesh, kept, {}, job()).report.joined_junctions, 0);
}

TEST(Junctions, StayWhereABoundWouldBreak) {
  // Each region is held to its plane by less than the next region's are away from it.
  Bricks bricks(0, 2);
  bricks.part.bound = 0.01;
  bricks.part.region_normal.assign(4, Vec3(0, 0, 1));
  bricks.part.region_offset = {0, 0, 0, 0};
  EXPECT_EQ(bricks.polygons(0.8).report.joined_junctions, 1);
  bricks.part.region_offset = {1, 1, 1, 1};
  EXPECT_EQ(bricks.polygons(0.8).report.joined_junctions, 0);
}

TEST(Junctions, OnARidgeBecomeOneOnTheRidge) {
  shapes::Arrays a = shapes::plane(kRows);
  for (Vec3& v : a.vertices) v.z() = 0.3 * std::abs(v.y() - 0.5);
  const Mesh mesh = shapes::mesh(a);
  Partition part = labelled::by(Bricks::labels(mesh, 2));
  const PolygonMesh polygons = polygonize(mesh, part, {}, job());
  EXPECT_EQ(polygons.report.joined_junctions, 1);
  EXPECT_TRUE(polygons.report.imperfect.empty());
  EXPECT_LT(polygons.report.planarity_max, 1e-12) << "all four planes go through the vertex";
}

TEST(Junctions, JoinedOnShapesOfAllKindsLeaveSoundPolygonsOnAnyThreads) {
  std::int64_t joined = 0;
  for (const int count : {12, 40, 120})
    for (const auto& shape : {shapes::noisy(shapes::sphere(4), 0.01, 1), shapes::noisy(shapes::torus(60, 30), 0.01, 2),
                              shapes::noisy(shapes::cube(16), 0.004, 3)}) {
      const Mesh mesh = shapes::mesh(shape);
      const Partition part = labelled::voronoi(mesh, count, 5);
      const PolygonMesh one = polygonize(mesh, part, {.threads = 1}, job());
      const PolygonMesh three = polygonize(mesh, part, {.threads = 3}, job());
      EXPECT_EQ(one.loops, three.loops);
      EXPECT_EQ(one.vertices, three.vertices);
      EXPECT_TRUE(one.report.closed && one.report.manifold);
      EXPECT_TRUE(one.report.imperfect.empty());
      joined += one.report.joined_junctions;
    }
  EXPECT_GT(joined, 20);
}

}  // namespace
}  // namespace isimp
