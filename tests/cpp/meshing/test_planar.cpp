// Exactly planar polygons, and planes that are snapped.
#include "isimp/meshing/polygonize.h"
#include "isimp/regular/regularise.h"
#include "labelled.h"
#include "polygon_judge.h"
#include "tests.h"

namespace isimp {
namespace {

constexpr double kPlanar = 1e-6;

PolygonMesh polygons(const Mesh& mesh, const Partition& part, MeshingOptions options = {.planar = true}) {
  return polygonize(mesh, part, options, job());
}

/// Largest distance of a corner from the plane of its polygon, after rounding to float32 about the origin.
double bend(const PolygonMesh& mesh, const Vec3& origin, bool rounded) {
  double most = 0;
  for (const judge::Loop& loop : judge::polygons_of(mesh)) {
    std::vector<Vec3> p;
    Vec3 middle = Vec3::Zero();
    for (const std::int32_t v : loop) {
      const Vec3 x = mesh.vertices[v] - origin;
      p.push_back(rounded ? rounded_to_float(x) : x);
      middle += p.back() / static_cast<double>(loop.size());
    }
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) area += (p[i] - middle).cross(p[(i + 1) % p.size()] - middle);
    for (const Vec3& x : p) most = std::max(most, std::abs((x - middle).dot(area.normalized())));
  }
  return most;
}

/// The polygons of a scan have no defect, all are planar, and the scan's topology is kept.
void expect_sound(const PolygonMesh& out, const Mesh& mesh, const Partition& part) {
  EXPECT_TRUE(out.report.planar.planar);
  EXPECT_LE(bend(out, mesh.origin(), false), kPlanar * mesh.diagonal());
  EXPECT_LE(bend(out, mesh.origin(), true), kPlanar * mesh.diagonal());
  EXPECT_EQ(judge::defects_against(out, mesh, part), "");
  EXPECT_TRUE(out.report.imperfect.empty());
  const PlanarReport& r = out.report.planar;
  EXPECT_EQ(r.faces_added, r.added_for_apart + r.added_for_crossing + r.added_for_flipped + r.added_for_meeting);
}

/// The unit cube with noise, its sides as regions.
struct Box {
  Mesh mesh;
  Partition part;
  explicit Box(double noise, const Vec3& at = Vec3::Zero()) : mesh(made(noise, at)), part(labels()) {}

  static Mesh made(double noise, const Vec3& at) {
    return shapes::mesh(shapes::moved(shapes::noisy(shapes::cube(12), noise, 3), at));
  }
  static Partition labels() { return labelled::planes(shapes::mesh(shapes::cube(12))); }
};

TEST(Planar, NoisyBoxStaysWholeAndIsPlanar) {
  for (const double noise : {0.0, 0.002, 0.006}) {
    const Box box(noise);
    const PolygonMesh out = polygons(box.mesh, box.part);
    expect_sound(out, box.mesh, box.part);
    EXPECT_EQ(out.polygon_count(), 6);
    EXPECT_EQ(out.report.planar.whole, 1.0);
    EXPECT_EQ(out.report.planar.faces_added, 0);
  }
}

TEST(Planar, FarFromZeroItIsAsPlanar) {
  const Vec3 utm(450000.25, 5500000.5, 112);
  const Box box(0.004, utm);
  expect_sound(polygons(box.mesh, box.part), box.mesh, box.part);
}

TEST(Planar, OffChangesNothing) {
  const Mesh ball = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.01, 5));
  const Partition part = labelled::voronoi(ball, 60, 7);
  const PolygonMesh plain = polygons(ball, part, {}), reach = polygons(ball, part, {.planar_reach = 0.02});
  EXPECT_EQ(plain.vertices, reach.vertices);
  EXPECT_EQ(plain.loops, reach.loops);
  EXPECT_FALSE(plain.report.planar.asked);
  EXPECT_GT(bend(plain, ball.origin(), false), kPlanar * ball.diagonal());
}

TEST(Planar, CurvedScansAreCut) {
  const Mesh ball = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.01, 5));
  const Partition part = labelled::voronoi(ball, 60, 7);
  const PolygonMesh before = polygons(ball, part, {}), after = polygons(ball, part);
  expect_sound(after, ball, part);
  EXPECT_GT(after.polygon_count(), before.polygon_count());
  EXPECT_GT(after.report.planar.faces_added, 0);
  EXPECT_LT(after.report.planar.whole, 1.0);
  for (const std::int32_t r : after.polygon_region) EXPECT_TRUE(r >= 0 && r < part.region_count());
}

/// Rough balls, with polygons far from planar: much is given up, finally the planes themselves.
TEST(Planar, RoughScansGetNoDefectThatTheyHadNot) {
  for (std::uint32_t seed = 1; seed <= checks::size(4, 2); ++seed)
    for (const int regions : {24, 60, 150}) {
      const double noise = seed % 2 == 0 ? 0.03 : 0.06;
      const Mesh ball = shapes::mesh(shapes::noisy(shapes::sphere(3), noise, seed));
      const Partition part = labelled::voronoi(ball, regions, seed);
      const MeshingReport before = polygons(ball, part, {}).report, after = polygons(ball, part).report;
      SCOPED_TRACE("seed " + std::to_string(seed) + ", regions " + std::to_string(regions));
      EXPECT_TRUE(after.planar.planar);
      EXPECT_LE(after.crossing, before.crossing);
      EXPECT_LE(after.flipped, before.flipped);
      EXPECT_LE(after.intersecting, before.intersecting);
      EXPECT_TRUE(after.manifold && after.closed);
      EXPECT_EQ(after.euler, before.euler);
    }
}

/// Crumpled balls, of which the repair's budget leaves a hundred polygons that cross themselves: planar ones are fewer.
TEST(Planar, CrumpledScansGetNoMoreDefectsThanTheyHad) {
  const auto defects = [](const MeshingReport& r) { return r.crossing + r.flipped + r.bent + r.intersecting; };
  for (int regions = 40; regions <= checks::size(100, 40); regions += 60) {
    const Mesh ball = shapes::mesh(shapes::noisy(shapes::sphere(3), 0.3, 1));
    const Partition part = labelled::voronoi(ball, regions, 1);
    const MeshingReport before = polygons(ball, part, {}).report, after = polygons(ball, part).report;
    EXPECT_GT(defects(before), 0);
    EXPECT_LE(defects(after), defects(before));
    EXPECT_TRUE(after.manifold && after.closed);
    EXPECT_EQ(after.euler, before.euler);
  }
}

TEST(Planar, OpenSheetsStayOpen) {
  shapes::Arrays a = shapes::noisy(shapes::plane(24), 0.003, 2);
  for (Vec3& v : a.vertices) v.z() += std::abs(v.x() - 0.5);
  const Mesh mesh = shapes::mesh(a);
  const Partition part = labelled::by(shapes::labels(mesh, [](const Vec3& c) {
    return c.x() > 0.25 - 1e-3 && c.x() < 0.4 && c.y() > 0.3 && c.y() < 0.7 ? 2 : c.x() < 0.5 ? 0 : 1;
  }));
  const PolygonMesh out = polygons(mesh, part);
  expect_sound(out, mesh, part);
  EXPECT_FALSE(out.report.closed);
}

TEST(Planar, SameBitsForAnyThreads) {
  const Mesh ball = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.02, 5));
  const Partition part = labelled::voronoi(ball, 80, 9);
  const PolygonMesh one = polygons(ball, part, {.planar = true, .threads = 1});
  const PolygonMesh four = polygons(ball, part, {.planar = true, .threads = 4});
  EXPECT_EQ(one.vertices, four.vertices);
  EXPECT_EQ(one.loops, four.loops);
  EXPECT_EQ(one.report, four.report);
}

Partition regular(const Box& box, RegulariseOptions options = {}) {
  return regularise(box.mesh, box.part, options, job());
}

TEST(Regularise, BoxGetsSixPlanesInThreeDirections) {
  const Box box(0.006);
  const Partition part = regular(box);
  ASSERT_TRUE(part.regularity);
  EXPECT_EQ(part.regularity->directions, 3);
  EXPECT_EQ(part.regularity->planes, 6);
  EXPECT_EQ(part.regularity->level, 2);
  EXPECT_EQ(part.regularity->upright, 4);
  EXPECT_LT(part.regularity->rms, 1.1 * part.regularity->rms_before);
  EXPECT_EQ(part.face_region, box.part.face_region);
  for (std::int32_t a = 0; a < 6; ++a)
    for (std::int32_t b = 0; b < a; ++b) {
      const double same = std::abs(part.region_normal[a].dot(part.region_normal[b]));
      EXPECT_TRUE(same < 1e-12 || same > 1 - 1e-12);
    }
}

TEST(Regularise, PolygonsKeepToThePlanes) {
  const Box box(0.002, Vec3(1000, 2000, 30));
  const Partition part = regular(box);
  for (const bool planar : {false, true}) {
    const PolygonMesh out = polygons(box.mesh, part, {.planar = planar});
    ASSERT_EQ(out.polygon_count(), 6);
    const std::vector<judge::Loop> loops = judge::polygons_of(out);
    for (std::int32_t q = 0; q < 6; ++q)
      for (const std::int32_t v : loops[q]) {
        const std::int32_t r = out.polygon_region[q];
        const double off = part.region_normal[r].dot(out.vertices[v]) - part.region_offset[r];
        EXPECT_LT(std::abs(off), (planar ? 1e-7 : 1e-3) * box.mesh.diagonal());
      }
  }
}

/// Two sides lean by 1.7 degrees. If a large length lets them snap, the corners move further than the reach of corners
/// whose planes are free.
TEST(Regularise, CornersGoToPlanesThatAreFurtherOffThanTheirReach) {
  shapes::Arrays a = shapes::cube(6);
  for (Vec3& v : a.vertices) {
    v = 2 * v - Vec3::Ones();
    if (v.z() > 0.999) v.z() += 0.03 * v.x();
    if (v.x() > 0.999) v.x() += 0.03 * v.z();
  }
  const Mesh mesh = shapes::mesh(a);
  const Partition part =
      regularise(mesh, labelled::planes(shapes::mesh(shapes::cube(6))), {.angle = 8, .length = 0.1}, job());
  ASSERT_EQ(part.regularity->directions, 3);
  const PolygonMesh out = polygons(mesh, part);
  expect_sound(out, mesh, part);
  EXPECT_EQ(out.report.planar.whole, 1.0);
  const std::vector<judge::Loop> loops = judge::polygons_of(out);
  for (std::int32_t q = 0; q < out.polygon_count(); ++q)
    for (const std::int32_t v : loops[q]) {
      const std::int32_t r = out.polygon_region[q];
      EXPECT_NEAR(part.region_normal[r].dot(out.vertices[v]), part.region_offset[r], 1e-6);
    }
}

TEST(Regularise, AShortLengthSnapsNothingAndOptionsAreChecked) {
  const Box box(0.006);
  const Partition part = regular(box, {.angle = 8, .length = 1e-12});
  EXPECT_EQ(part.regularity->free, 6);
  EXPECT_EQ(std::count(part.region_held.begin(), part.region_held.end(), 1), 0);
  EXPECT_THROW(regular(box, {.angle = 90, .length = {}}), InvalidInput);
  EXPECT_EQ(regular(box, {.angle = 8, .length = {}, .up = Up::none}).regularity->upright, 0);
}

}  // namespace
}  // namespace isimp
