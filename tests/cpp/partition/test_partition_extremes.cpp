// Extreme inputs: hardly any faces a region, ten thousand components, slivers, nothing but a plane.
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::expect_sound;
using checks::run;

/// Sound, with the requested number of regions, and the same on two threads.
Partition run_checked(const Mesh& mesh, PartitionOptions options) {
  options.threads = 1;
  const Partition result = run(mesh, options);
  expect_sound(mesh, result, *options.proxies);
  options.threads = 2;
  EXPECT_EQ(run(mesh, options).face_region, result.face_region);
  return result;
}

std::vector<std::int32_t> sizes(const Partition& p) {
  std::vector<std::int32_t> faces;
  for (const RegionSum& sum : p.region_sum) faces.push_back(sum.faces);
  return faces;
}

TEST(Extremes, FacesWithoutAreaCountNothingHoweverSmallTheRestIs) {
  // Two slivers at right angles, the second too thin to have a normal of its own.
  const Mesh slivers =
      shapes::mesh({{{0, 0, 0}, {1, 0, 0}, {0.5, 1.5e-12, 0}, {0.5, 0, 0.5e-12}}, {{0, 1, 2}, {1, 0, 3}}});
  EXPECT_EQ(slivers.report().zero_area_faces, 1);
  EXPECT_DOUBLE_EQ(slivers.report().area, 0.75e-12);
  EXPECT_EQ(run_checked(slivers, {.proxies = 1}).error, 0.0);

  shapes::Arrays tiny = shapes::scaled(shapes::cube(2), 1e-25);
  const auto n = static_cast<std::int32_t>(tiny.vertices.size());
  for (const double x : {1.0, 2.0, 3.0}) tiny.vertices.emplace_back(x, 0, 0);
  tiny.triangles.push_back({n, n + 1, n + 2});
  const Partition cube = run_checked(shapes::mesh(tiny), {.proxies = 6});
  EXPECT_NEAR(cube.error, 0.0, 1e-56);
  EXPECT_EQ(cube.parts_left_out, 1);
}

TEST(Extremes, TwentyFacesARegion) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(5), 0.002, 1));
  const PartitionOptions options{.proxies = mesh.face_count() / 20, .metric = Metric::normals};
  const Partition p = run_checked(mesh, options);
  const Partition plain = run(mesh, {.proxies = options.proxies, .method = Method::lloyd});
  EXPECT_LT(p.error, 0.9 * plain.error);
}

TEST(Extremes, TenThousandCubesWithTheirSixSides) {
  constexpr std::int32_t kCubes = 10'000;
  const shapes::Arrays cube = shapes::cube();
  shapes::Arrays all;
  for (std::int32_t k = 0; k < kCubes; ++k) {
    const auto first = static_cast<std::int32_t>(all.vertices.size());
    for (const Vec3& v : cube.vertices) all.vertices.emplace_back(v + 2 * Vec3(k % 22, k / 22 % 22, k / 484));
    for (const Triangle& t : cube.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  const Mesh mesh = shapes::mesh(all);
  const Partition p = run_checked(mesh, {.proxies = 6 * kCubes, .leave_out = 0});
  EXPECT_NEAR(p.error, 0.0, 1e-9 * mesh.report().area);
  const Partition least = run(mesh, {.proxies = 1, .leave_out = 0});
  expect_sound(mesh, least);
  EXPECT_EQ(least.proxies_needed, 4 * kCubes);
  EXPECT_EQ(least.region_count(), 4 * kCubes);
}

TEST(Extremes, SliversCountByTheirArea) {
  // 2,000 squares around the ring and 6 around the tube, each about a hundred times as long as it is wide.
  const Mesh mesh = shapes::mesh(shapes::torus(2000, 6));
  const Partition p = run_checked(mesh, {.proxies = 60});
  const Partition plain = run(mesh, {.proxies = 60, .method = Method::lloyd});
  EXPECT_LT(p.error, plain.error);
}

TEST(Extremes, APlaneIsSharedOutThoughItsFacesAreAllAlike) {
  const Mesh mesh = shapes::mesh(shapes::plane(60));
  const Partition p = run_checked(mesh, {.proxies = 100});
  EXPECT_NEAR(p.error, 0.0, 1e-9 * mesh.report().area);
  const std::vector<std::int32_t> faces = sizes(p);
  EXPECT_LE(*std::max_element(faces.begin(), faces.end()), 10 * mesh.face_count() / 100);
  const Partition whole = run_checked(mesh, {.proxies = 1});
  EXPECT_NEAR(whole.region_normal[0].z(), 1.0, 1e-12);
}

}  // namespace
}  // namespace isimp
