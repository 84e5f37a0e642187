#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::expect_sound;
using checks::run;

TEST(Partition, CubeSplitsIntoItsSixSides) {
  const Mesh mesh = shapes::mesh(shapes::cube(8));
  const Partition p = run(mesh, {.proxies = 6, .seeding = Seeding::farthest, .method = Method::lloyd});
  expect_sound(mesh, p, 6);
  EXPECT_NEAR(p.error, 0.0, 1e-12);
  for (const Vec3& normal : p.region_normal) EXPECT_NEAR(normal.cwiseAbs().maxCoeff(), 1.0, 1e-12);
}

TEST(Partition, HasExactlyTheRequestedRegions) {
  const Mesh sphere = shapes::mesh(shapes::shuffled(shapes::noisy(shapes::sphere(3), 0.01, 1), 2));
  for (const Method method : {Method::lloyd, Method::hierarchy, Method::teleport})
    for (const std::int32_t proxies : {4, 5, 37, 300, 1279, 1280}) {
      const Partition p = run(sphere, {.proxies = proxies, .seed = 7, .method = method});
      expect_sound(sphere, p, proxies);
    }
}

TEST(Partition, OneRegionForEveryFaceHasNoError) {
  const Mesh mesh = shapes::mesh(shapes::torus(12, 8));
  const Partition p = run(mesh, {.proxies = mesh.face_count(), .method = Method::lloyd});
  expect_sound(mesh, p);
  EXPECT_NEAR(p.error, 0.0, 1e-12);
}

TEST(Partition, OneProxyTakesAnOpenSurfaceWhole) {
  const Mesh mesh = shapes::mesh(shapes::plane(6));
  const Partition p = run(mesh, {.proxies = 1, .method = Method::lloyd});
  expect_sound(mesh, p, 1);
  EXPECT_NEAR(p.error, 0.0, 1e-12);
  EXPECT_NEAR(p.region_normal[0].z(), 1.0, 1e-12);
}

TEST(Partition, AClosedSurfaceGetsFourEvenIfOneIsRequested) {
  const Mesh mesh = shapes::mesh(shapes::cube(3));
  const Partition p = run(mesh, {.proxies = 1, .method = Method::lloyd});
  expect_sound(mesh, p, 4);
  EXPECT_EQ(p.proxies_asked, 1);
  EXPECT_EQ(p.proxies_needed, 4);
}

TEST(Partition, EveryComponentGetsItsLeastThenByNeed) {
  // Two unit cubes and an open square: 4 + 4 + 1 at least.
  const auto cubes = shapes::both(shapes::cube(4), shapes::cube(4), {3, 0, 0});
  const Mesh mesh = shapes::mesh(shapes::both(cubes, shapes::plane(4), {0, 0, 5}));
  const Partition least = run(mesh, {.proxies = 2, .method = Method::lloyd});
  expect_sound(mesh, least, 9);
  const Partition p = run(mesh, {.proxies = 13, .method = Method::lloyd});
  expect_sound(mesh, p, 13);
  std::vector<std::set<std::int32_t>> regions(3);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) regions[mesh.component()[f]].insert(p.face_region[f]);
  EXPECT_EQ(regions[0].size(), 6U);
  EXPECT_EQ(regions[1].size(), 6U);
  EXPECT_EQ(regions[2].size(), 1U);  // a flat part needs no more
}

TEST(Partition, SpecksAreLeftOutSmallestFirst) {
  // A big cube and five small ones, each 3.6e-5 of its area.
  auto arrays = shapes::cube(4);
  const auto speck = shapes::scaled(shapes::cube(1), 0.006);
  for (int k = 0; k < 5; ++k) arrays = shapes::both(arrays, speck, {2.0 + k, 0, 0});
  const Mesh mesh = shapes::mesh(arrays);
  const Partition p = run(mesh, {.proxies = 6, .method = Method::lloyd});
  expect_sound(mesh, p, 6);
  EXPECT_EQ(p.parts_left_out, 5);
  EXPECT_NEAR(p.area_left_out, 5 * 3.6e-5, 1e-6);
  EXPECT_EQ(p.face_region.back(), kNone);

  const Partition all = run(mesh, {.proxies = 6, .leave_out = 0, .method = Method::lloyd});
  expect_sound(mesh, all, 24);
  EXPECT_EQ(all.parts_left_out, 0);

  // Each is below 4e-5, and four of them are below ten times 1.5e-5 but not above it: none is below 1.5e-5, though.
  EXPECT_EQ(run(mesh, {.proxies = 6, .leave_out = 1.5e-5, .method = Method::lloyd}).parts_left_out, 0);
  EXPECT_EQ(run(mesh, {.proxies = mesh.face_count(), .method = Method::lloyd}).parts_left_out, 0);
}

TEST(Partition, LeavesOutMoreWhereEachPartIsFarBelowARegion) {
  // Thirty parts of .00051 of the area each: nineteen of them stay below ten times .001, all below twenty times.
  auto arrays = shapes::plane(30);
  const auto speck = shapes::scaled(shapes::plane(1), std::sqrt(0.00051 / (1 - 30 * 0.00051)));
  for (int k = 1; k <= 30; ++k) arrays = shapes::both(arrays, speck, {2.0 * k, 0, 0});
  const Mesh mesh = shapes::mesh(arrays);
  const auto left_out = [&](const PartitionOptions& options) { return run(mesh, options).parts_left_out; };
  EXPECT_EQ(left_out({.proxies = 150}), 30);  // a tenth of the mean region is .00067
  EXPECT_EQ(left_out({.proxies = 250}), 19);  // .0004
  EXPECT_EQ(left_out({.proxies = 150, .leave_out = 0.0007}), 27);
  EXPECT_EQ(left_out({.detail = 0.01}), 19);
}

TEST(Partition, LeavesOutOnlyWhileTogetherBelowTenTimesTheShare) {
  // A hundred and one equal parts, each .0099 of the area: ten of them stay below ten times .01.
  auto arrays = shapes::plane(1);
  for (int k = 1; k <= 100; ++k) arrays = shapes::both(arrays, shapes::plane(1), {2.0 * k, 0, 0});
  const Mesh mesh = shapes::mesh(arrays);
  const Partition p = run(mesh, {.proxies = 91, .leave_out = 0.01, .method = Method::lloyd});
  expect_sound(mesh, p);
  EXPECT_EQ(p.parts_left_out, 10);
  EXPECT_EQ(p.region_count(), 91);
}

TEST(Partition, ManyEqualPartsShareEvenly) {
  auto arrays = shapes::cube(2);
  for (int k = 1; k < 20; ++k) arrays = shapes::both(arrays, shapes::cube(2), {2.0 * k, 0, 0});
  const Mesh mesh = shapes::mesh(arrays);
  const Partition p = run(mesh, {.proxies = 130, .leave_out = 0, .method = Method::lloyd});
  expect_sound(mesh, p);
  std::vector<std::set<std::int32_t>> regions(20);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) regions[mesh.component()[f]].insert(p.face_region[f]);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(regions[k].size(), k < 10 ? 7U : 6U);
}

TEST(Partition, HistoryFallsAndEndsEarlyWhereNothingChanges) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.003, 5));
  const Partition p = run(mesh, {.proxies = 40, .iterations = 20, .method = Method::lloyd});
  expect_sound(mesh, p);
  EXPECT_GE(p.history.size(), 5U);
  EXPECT_LE(p.history.size(), 20U);
  EXPECT_LT(p.error, 0.9 * p.history.front());
  const Mesh plane = shapes::mesh(shapes::plane(8));
  EXPECT_LT(run(plane, {.proxies = 5, .iterations = 100, .method = Method::lloyd}).history.size(), 100U);
}

TEST(Partition, SameInputSameBits) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(40, 20), 0.01, 3));
  for (const Seeding seeding : {Seeding::random, Seeding::farthest})
    for (const Method method : {Method::lloyd, Method::hierarchy, Method::teleport}) {
      const PartitionOptions options{.proxies = 50, .seed = 4, .seeding = seeding, .method = method};
      const Partition a = run(mesh, options), b = run(mesh, options);
      EXPECT_EQ(a.face_region, b.face_region);
      EXPECT_EQ(a.error, b.error);
      EXPECT_EQ(a.history, b.history);
    }
  EXPECT_NE(run(mesh, {.proxies = 50, .seed = 4, .method = Method::lloyd}).face_region,
            run(mesh, {.proxies = 50, .seed = 5, .method = Method::lloyd}).face_region);
}

TEST(Partition, OptionsOutOfRangeAreNamed) {
  const Mesh mesh = shapes::mesh(shapes::cube());
  const auto message = [&](const PartitionOptions& options) { return message_of([&] { run(mesh, options); }); };
  EXPECT_EQ(message({.proxies = 0}), "proxies must be in [1, 12], got 0");
  EXPECT_EQ(message({.proxies = 13}), "proxies must be in [1, 12], got 13");
  EXPECT_EQ(message({.proxies = 6, .leave_out = 1}), "leave_out must be in [0, 1), got 1");
  EXPECT_EQ(message({.proxies = 6, .leave_out = -0.5}), "leave_out must be in [0, 1), got -0.5");
  EXPECT_EQ(message({.proxies = 6, .leave_out = std::numeric_limits<double>::quiet_NaN()}),
            "leave_out must be in [0, 1), got nan");
  EXPECT_EQ(message({.proxies = 6, .iterations = 0}), "iterations must be at least 1, got 0");
  EXPECT_EQ(message({.proxies = 6, .threads = -1}), "threads must be at least 0, got -1");
  EXPECT_EQ(message({.proxies = 6, .backend = "gpu"}), "unknown back end 'gpu'; there is: cpu");
}

TEST(Partition, BadInputIsNamedEvenWhenCancelledAndACancelStopsIt) {
  const Mesh mesh = shapes::mesh(shapes::cube(4));
  Job job;
  job.cancel();
  EXPECT_THROW(partition(mesh, {.proxies = 0}, job), InvalidInput);
  EXPECT_THROW(partition(mesh, {.proxies = 6}, job), Cancelled);
}

}  // namespace
}  // namespace isimp
