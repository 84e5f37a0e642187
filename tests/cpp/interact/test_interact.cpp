#include "isimp/interact/heuristics.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "isimp/meshing/polygonize.h"
#include "partition_checks.h"
#include "polygon_judge.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::expect_sound;
using checks::run;

Partition add(const Mesh& mesh, const Partition& p, std::int32_t face) { return add_proxy(mesh, p, face, job()); }
Partition remove(const Mesh& mesh, const Partition& p, std::int32_t face) { return delete_proxy(mesh, p, face, job()); }

Mesh cube_and_speck() {
  return shapes::mesh(shapes::both(shapes::cube(4), shapes::scaled(shapes::cube(1), 0.006), {2, 0, 0}));
}

TEST(AddProxy, TakesTheLastNumberAndTheFace) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.002, 1));
  Partition p = run(mesh, {.proxies = 20});
  for (std::int32_t face = 0; face < mesh.face_count(); face += 511) {
    const std::int32_t regions = p.region_count();
    const double before = p.error;
    p = add(mesh, p, face);
    expect_sound(mesh, p, regions + 1);
    EXPECT_EQ(p.face_region[face], regions);
    EXPECT_LT(p.error, before);
  }
}

TEST(AddProxy, ChangesOnlyItsRegionAndItsNeighbours) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.002, 1));
  const Partition before = run(mesh, {.proxies = 100});
  const Partition after = add(mesh, before, 17);
  std::int32_t changed = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) changed += before.face_region[f] != after.face_region[f];
  EXPECT_GT(changed, 0);
  EXPECT_LT(changed, mesh.face_count() / 10);
}

TEST(AddProxy, SplitsAFlatSideInTwoHalvesOfSomeSize) {
  const Mesh mesh = shapes::mesh(shapes::plane(16));
  const Partition p = add(mesh, run(mesh, {.proxies = 1}), 100);
  expect_sound(mesh, p);
  EXPECT_GT(p.region_sum[0].faces, mesh.face_count() / 10);
  EXPECT_GT(p.region_sum[1].faces, mesh.face_count() / 10);
}

TEST(AddProxy, SplitsTwoSidesOfACubeAtTheirEdge) {
  // The two squares of an open book: one region over both; a proxy anywhere on one parts them at the crease.
  shapes::Arrays book = shapes::plane(6);
  for (Vec3& v : book.vertices)
    if (v.x() > 0.5) v = {0.5, v.y(), v.x() - 0.5};
  const Mesh mesh = shapes::mesh(book);
  const Partition one = run(mesh, {.proxies = 1});
  EXPECT_GT(one.error, 0.1);
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const Partition two = add(mesh, one, face);
    expect_sound(mesh, two);
    EXPECT_NEAR(two.error, 0.0, 1e-12) << face;
  }
}

/// The numbers of corners of each region's polygons, the last region's at the end, the others' in rising order.
std::vector<std::int32_t> sizes(const Mesh& mesh, const Partition& p) {
  const PolygonMesh polygons = polygonize(mesh, p, {}, job());
  std::vector<std::int32_t> result(static_cast<std::size_t>(p.region_count()), 0);
  const std::vector<judge::Loop> loops = judge::polygons_of(polygons);
  for (std::size_t q = 0; q < loops.size(); ++q)
    result[polygons.polygon_region[q]] += static_cast<std::int32_t>(loops[q].size());
  std::sort(result.begin(), result.end() - 1);
  return result;
}

TEST(AddProxy, CutsACornerOfASmoothedCubeByATriangle) {
  const shapes::Arrays straight = shapes::smoothed(shapes::cube(20), 5);
  for (int turn = 0; turn < 3; ++turn) {
    shapes::Arrays cube = straight;
    for (Vec3& v : cube.vertices) v = Eigen::AngleAxisd(turn * 1.1, Vec3(1, 2, 3 + turn).normalized()) * v;
    const Mesh mesh = shapes::mesh(cube);
    const Partition six = run(mesh, {.proxies = 6});
    for (int corner = 0; corner < 8; ++corner) {
      // The three faces at the tip and their three neighbours.
      const Vec3 tip(corner & 1, corner >> 1 & 1, corner >> 2);
      std::vector<std::pair<double, std::int32_t>> faces;
      for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
        const auto [a, b, c] = straight.triangles[f];
        const Vec3 middle = (straight.vertices[a] + straight.vertices[b] + straight.vertices[c]) / 3;
        faces.emplace_back((middle - tip).norm(), f);
      }
      std::sort(faces.begin(), faces.end());
      for (int k = 0; k < 6; ++k) {
        const Partition seven = add(mesh, six, faces[k].second);
        expect_sound(mesh, seven);
        EXPECT_EQ(seven.face_region[faces[k].second], 6);
        EXPECT_EQ(sizes(mesh, seven), (std::vector<std::int32_t>{4, 4, 4, 5, 5, 5, 3})) << faces[k].second;
      }
    }
  }
}

TEST(AddProxy, BevelsAnEdgeOfASmoothedCubeFromEndToEnd) {
  const Mesh mesh = shapes::mesh(shapes::smoothed(shapes::cube(20), 5));
  const Partition six = run(mesh, {.proxies = 6});
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3 middle = shapes::middle(mesh, f);
    if (std::abs(middle.z() - 0.5) > 0.2 || middle.x() < 0.95 || middle.y() < 0.95) continue;
    const Partition seven = add(mesh, six, f);
    expect_sound(mesh, seven);
    EXPECT_LT(seven.error, six.error);
    EXPECT_NEAR(seven.region_normal[6].dot(Vec3(1, 1, 0).normalized()), 1.0, 0.02);
    EXPECT_NEAR(seven.region_sum[6].faces, 80, 10);
  }
}

TEST(AddProxy, RestoresAPartThatWasLeftOut) {
  const Mesh mesh = cube_and_speck();
  const Partition p = run(mesh, {.proxies = 6});
  ASSERT_EQ(p.parts_left_out, 1);
  const Partition back = add(mesh, p, mesh.face_count() - 1);
  expect_sound(mesh, back, 7);
  EXPECT_EQ(back.parts_left_out, 0);
  EXPECT_EQ(back.area_left_out, 0.0);
  for (std::int32_t f = mesh.face_count() - 12; f < mesh.face_count(); ++f) EXPECT_EQ(back.face_region[f], 6);
}

TEST(DeleteProxy, AddsTheFacesToTheRegionsAround) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.002, 1));
  Partition p = run(mesh, {.proxies = 30});
  for (std::int32_t face = 0; face < mesh.face_count(); face += 311) {
    const std::int32_t regions = p.region_count();
    p = remove(mesh, p, face);
    expect_sound(mesh, p, regions - 1);
  }
}

TEST(DeleteProxy, UndoesAnAddOnACube) {
  const Mesh mesh = shapes::mesh(shapes::cube(6));
  const Partition six = run(mesh, {.proxies = 6, .seeding = Seeding::farthest});
  ASSERT_NEAR(six.error, 0.0, 1e-12);
  for (const std::int32_t face : {0, 37, 200, 431}) {
    const Partition seven = add(mesh, six, face);
    EXPECT_EQ(seven.region_count(), 7);
    EXPECT_NEAR(seven.error, 0.0, 1e-12);
    const Partition again = remove(mesh, seven, face);
    EXPECT_NEAR(again.error, 0.0, 1e-12);
    EXPECT_EQ(again.face_region, six.face_region);
  }
}

TEST(DeleteProxy, DecreasesHigherNumbers) {
  const Mesh mesh = shapes::mesh(shapes::cube(6));
  const Partition six = run(mesh, {.proxies = 6, .seeding = Seeding::farthest});
  const Partition five = remove(mesh, six, six.region_seed[2]);
  expect_sound(mesh, five);
  EXPECT_EQ(five.face_region[six.region_seed[1]], 1);
  EXPECT_EQ(five.face_region[six.region_seed[5]], 4);
}

TEST(Interact, ImpossibleEditsAreNamed) {
  const Mesh cube = shapes::mesh(shapes::cube());
  const Partition twelve = run(cube, {.proxies = 12});
  EXPECT_EQ(message_of([&] { add(cube, twelve, 3); }),
            "the region of face 3 is that face alone: there is nothing to split");
  EXPECT_EQ(message_of([&] { add(cube, twelve, -1); }), "face must be in [0, 12), got -1");
  EXPECT_EQ(message_of([&] { remove(cube, twelve, 12); }), "face must be in [0, 12), got 12");
  const Mesh plane = shapes::mesh(shapes::plane(2));
  const Partition one = run(plane, {.proxies = 1});
  EXPECT_EQ(message_of([&] { remove(plane, one, 2); }),
            "the region of face 2 is the only one of its part: it can't be deleted");
  EXPECT_EQ(message_of([&] { add(plane, twelve, 2); }),
            "the partition has 12 faces and the mesh has 8: it was made for another mesh");
  const Mesh both = cube_and_speck();
  const Partition left_out = run(both, {.proxies = 6});
  EXPECT_EQ(message_of([&] { remove(both, left_out, both.face_count() - 1); }),
            "face 203 lies in a part that was left out");
}

/// A partition of another program may have a region with a stray face: edits at either of its pieces would leave the
/// other.
TEST(Interact, ARegionInSeveralPiecesIsRefused) {
  const Mesh mesh = shapes::mesh(shapes::cube(6));
  Partition p = run(mesh, {.proxies = 6, .seeding = Seeding::farthest});
  const auto inside = [&](std::int32_t f) {
    const auto in_one = [&](std::int32_t h) { return p.face_region[mesh.opposite(h) / 3] == 1; };
    return p.face_region[f] == 1 && in_one(3 * f) && in_one(3 * f + 1) && in_one(3 * f + 2);
  };
  std::int32_t stray = 0;
  while (!inside(stray)) ++stray;
  const std::int32_t from = 1, rest = p.region_seed[0];
  p.region_sum[from].remove(mesh.graph().faces[mesh.graph().graph_face[stray]]);
  p.region_sum[0].add(mesh.graph().faces[mesh.graph().graph_face[stray]]);
  p.face_region[stray] = 0;
  const std::string what =
      " is in several pieces: 1 of its 73 faces hang together with that face; only connected regions can be edited";
  const std::string named = "the region of face " + std::to_string(stray) + what;
  EXPECT_EQ(message_of([&] { (void)split_region(mesh, p, stray, job()); }), named);
  EXPECT_EQ(message_of([&] { (void)add_proxy(mesh, p, stray, job()); }), named);
  EXPECT_EQ(message_of([&] { (void)delete_proxy(mesh, p, stray, job()); }), named);
  EXPECT_EQ(message_of([&] { (void)grow_region(mesh, p, stray, 1, job()); }), named);
  EXPECT_EQ(message_of([&] { (void)shrink_region(mesh, p, stray, 1, job()); }), named);
  const Vec3 line[] = {Vec3(-1, 0.5, 0.5), Vec3(2, 0.5, 0.5)};
  EXPECT_EQ(message_of([&] { (void)split_along(mesh, p, stray, line, Vec3::Zero(), job()); }), named);
  EXPECT_NE(message_of([&] { (void)split_region(mesh, p, rest, job()); }).find("72 of its 73 faces"),
            std::string::npos);
  EXPECT_EQ(message_of([&] { (void)improve(mesh, p, job()); }),
            "region 0 is in several pieces: only connected regions can be improved");
  EXPECT_NE(message_of([&] { (void)merge_regions(mesh, p, p.region_seed[2], rest, job()); }), "no error");
}

TEST(Interact, ACancelledJobStopsIt) {
  const Mesh cube = shapes::mesh(shapes::cube(4));
  const Partition six = run(cube, {.proxies = 6});
  Job job;
  job.cancel();
  EXPECT_THROW(add_proxy(cube, six, 0, job), Cancelled);
  EXPECT_THROW(delete_proxy(cube, six, 0, job), Cancelled);
}

}  // namespace
}  // namespace isimp
