// Decimation, and proxies carried back from the decimated mesh.

#include "hybrid.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::expect_sound;

Partition hybrid(const Surface& surface, PartitionOptions options) {
  options.method = Method::hybrid;
  return partition(surface, options, job());
}

Decimated coarse_of(const Surface& surface, double fraction) { return decimate(surface, fraction, job()); }

TEST(Decimate, KeepsAFractionOfTheFacesAndVerticesOfTheMesh) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(60, 30), 0.005, 2));
  for (const double fraction : {1.0, 0.5, 0.125}) {
    const Decimated coarse = coarse_of(mesh, fraction);
    EXPECT_EQ(coarse.triangles.size(), static_cast<std::size_t>(fraction * mesh.face_count()));
    EXPECT_EQ(std::set(coarse.vertex.begin(), coarse.vertex.end()).size(), coarse.vertex.size());
    std::vector<Vec3> vertices;
    for (const std::int32_t v : coarse.vertex) vertices.push_back(mesh.vertices()[v]);
    const Mesh made(vertices, coarse.triangles, job());
    EXPECT_TRUE(made.report().closed);
    EXPECT_EQ(made.report().components, 1);
    EXPECT_NEAR(made.report().area, mesh.report().area, 0.03 * mesh.report().area);
  }
}

TEST(Decimate, FlatSidesOfACubeAreReducedFirst) {
  const Decimated coarse = coarse_of(shapes::mesh(shapes::cube(8)), 0.02);  // 16 of 768 faces, 12 are the least
  EXPECT_LE(coarse.triangles.size(), 16U);
  EXPECT_GE(coarse.triangles.size(), 12U);
}

TEST(Hybrid, CubeSplitsIntoItsSixSides) {
  const Mesh mesh = shapes::mesh(shapes::cube(16));
  const Partition p = hybrid(mesh, {.proxies = 6, .seeding = Seeding::farthest, .fraction = 0.1});
  expect_sound(mesh, p, 6);
  EXPECT_NEAR(p.error, 0.0, 1e-12);
}

TEST(Hybrid, HasExactlyTheRequestedRegionsAndErrsLittle) {
  const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::noisy(shapes::torus(48, 24), 0.002, 2), 3));
  const double lloyd = partition(mesh, {.proxies = 100, .method = Method::lloyd}, job()).error;
  for (const std::int32_t proxies : {4, 100, 250}) {
    const Partition p = hybrid(mesh, {.proxies = proxies});
    expect_sound(mesh, p, proxies);
    if (proxies == 100) {
      EXPECT_LT(p.error, 1.25 * lloyd);
    }
    EXPECT_EQ(hybrid(mesh, {.proxies = proxies}).face_region, p.face_region);
  }
}

TEST(Hybrid, ErrsLessThanTheThesissOwn) {
  const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::noisy(shapes::torus(48, 24), 0.001, 2), 3));
  const Partition flooded = hybrid(mesh, {.proxies = 100, .connect = Connect::flood});
  expect_sound(mesh, flooded);
  const Partition relaxed = hybrid(mesh, {.proxies = 100, .threads = 1});
  expect_sound(mesh, relaxed);
  EXPECT_LT(relaxed.error, flooded.error);
  EXPECT_EQ(hybrid(mesh, {.proxies = 100, .threads = 3}).face_region, relaxed.face_region);
}

TEST(Hybrid, ComponentsKeepTheirRegionsAndSpecksAreLeftOut) {
  auto arrays = shapes::both(shapes::cube(6), shapes::sphere(3), {3, 0, 0});
  const auto speck = shapes::scaled(shapes::cube(2), 0.006);
  arrays = shapes::both(shapes::both(speck, arrays, {9, 0, 0}), shapes::plane(6), {0, 0, 5});
  const Mesh mesh = shapes::mesh(arrays);
  for (const std::int32_t proxies : {1, 9, 40}) {
    const Partition p = hybrid(mesh, {.proxies = proxies});
    expect_sound(mesh, p, std::max(proxies, 9));
    EXPECT_EQ(p.parts_left_out, 1);
    EXPECT_EQ(p.face_region.front(), kNone);
  }
}

TEST(Hybrid, BarriersAndWeightsAreKept) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::plane(16), 0.0, 1));
  Guides guides;
  for (std::int32_t i = 0; i < mesh.vertex_count(); ++i)  // along x = 1/2, from border to border
    for (std::int32_t j = 0; j < mesh.vertex_count(); ++j)
      if (const Vec3 a = mesh.vertices()[i], b = mesh.vertices()[j];
          a.x() == 0.5 && b.x() == 0.5 && std::abs(b.y() - a.y() - 0.0625) < 1e-9)
        guides.barriers.push_back({i, j});
  ASSERT_EQ(guides.barriers.size(), 16U);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) guides.weights.push_back(f % 3 == 0 ? 2.0 : 1.0);
  const Surface surface(mesh, guides, job());
  const Partition p = hybrid(surface, {.proxies = 6, .fraction = 0.25});
  expect_sound(mesh, p, 6);
  std::vector<std::set<bool>> sides(6);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    sides[p.face_region[f]].insert(shapes::middle(mesh, f).x() < 0.5);
  for (const auto& side : sides) EXPECT_EQ(side.size(), 1U);
  EXPECT_EQ(p.guided, surface.guided());
}

TEST(Hybrid, BadInputIsNamedAndACancelStopsIt) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const auto message = [&](const PartitionOptions& options) { return message_of([&] { hybrid(mesh, options); }); };
  EXPECT_EQ(message({.proxies = 0}), "proxies must be in [1, 1280], got 0");
  EXPECT_EQ(message({.proxies = 6, .fraction = 0}).substr(0, 26), "fraction must be in (0, 1]");
  EXPECT_EQ(message({.proxies = 6, .fraction = 1.5}).substr(0, 26), "fraction must be in (0, 1]");
  EXPECT_EQ(message({.proxies = 200}).substr(0, 39), "the mesh has 160 faces left at fraction");
  Job job;
  job.cancel();
  EXPECT_THROW(decimate(mesh, 0.5, job), Cancelled);
}

}  // namespace
}  // namespace isimp
