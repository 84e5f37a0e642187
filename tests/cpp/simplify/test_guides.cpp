#include "isimp/interact/interact.h"
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::edges_where;

Partition run(const Surface& surface, const PartitionOptions& options) { return partition(surface, options, job()); }

std::string message(const Mesh& mesh, const Guides& guides) {
  return message_of([&] { const Surface surface(mesh, guides, job()); });
}

bool kept(const Mesh& mesh, const Partition& part, const std::vector<std::array<std::int32_t, 2>>& barriers) {
  const std::set<std::array<std::int32_t, 2>> all(barriers.begin(), barriers.end());
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (mesh.opposite(h) != kNone && all.contains({mesh.from(h), mesh.to(h)}) &&
        part.face_region[Mesh::face(h)] == part.face_region[Mesh::face(mesh.opposite(h))])
      return false;
  return true;
}

TEST(Guides, BadOnesAreNamed) {
  const Mesh mesh = shapes::mesh(shapes::cube());
  EXPECT_EQ(message(mesh, {.weights = {1, 2}, .barriers = {}}),
            "there are 2 weights, but the mesh has 12 faces: give one for each");
  std::vector<double> weights(12, 1.0);
  weights[7] = -1;
  EXPECT_EQ(message(mesh, {weights, {}}), "the weight of face 7 is -1; weights must be finite and at least 0");
  weights[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(mesh, {weights, {}}).find("face 7"), std::string::npos);
  EXPECT_EQ(message(mesh, {std::vector<double>(12, 0.0), {}}), "all weights are 0; at least one must be above 0");
  // Vertices 0 and 6 are the ends of no edge if every other vertex is; each edge of the first triangle is one.
  const auto [a, b, c] = mesh.triangles()[0];
  EXPECT_EQ(message(mesh, {{}, {{a, b}, {c, b}, {a, a}}}), "barrier 2 runs between vertices " + std::to_string(a) +
                                                               " and " + std::to_string(a) +
                                                               ", but there is no such edge in the mesh");
  EXPECT_NE(message(mesh, {{}, {{0, 99}}}).find("vertices 0 and 99"), std::string::npos);
  EXPECT_NE(message(mesh, {{}, {{-1, 0}}}).find("vertices -1 and 0"), std::string::npos);
}

TEST(Guides, AnyEdgeMayBeABarrierAlsoOnABorder) {
  const Mesh mesh = shapes::mesh(shapes::plane(3));
  Guides guides;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) guides.barriers.push_back({mesh.to(h), mesh.from(h)});
  EXPECT_EQ(Surface(mesh, guides, job()).component_count(), mesh.face_count());
}

TEST(Barriers, AreKeptByEveryMethodAndEdit) {
  // The plane x = .5 of a cube's sides: it cuts through four of them.
  const Mesh mesh = shapes::mesh(shapes::cube(8));
  const Guides guides{{}, edges_where(mesh, [](const Vec3& p) { return std::abs(p.x() - 0.5) < 1e-9; })};
  const Surface surface(mesh, guides, job());
  EXPECT_EQ(surface.component_count(), 2);
  for (const Method method : {Method::lloyd, Method::hierarchy, Method::teleport}) {
    Partition part = run(surface, {.proxies = 10, .method = method});
    EXPECT_EQ(part.region_count(), 10);
    EXPECT_TRUE(kept(mesh, part, guides.barriers));
    part = add_proxy(mesh, part, 5, job());
    EXPECT_TRUE(kept(mesh, part, guides.barriers));
    part = delete_proxy(mesh, delete_proxy(mesh, part, 5, job()), 700, job());
    EXPECT_TRUE(kept(mesh, part, guides.barriers));
  }
  EXPECT_NEAR(run(surface, {.proxies = 10}).error, 0.0, 1e-9);
}

TEST(Barriers, DoNotMakePiecesThatAreLeftOut) {
  const Mesh mesh = shapes::mesh(shapes::plane(40));
  const std::int32_t corner = 0;  // its three edges cut one face of 3200 off
  Guides guides;
  for (std::int32_t h = 3 * corner; h < 3 * corner + 3; ++h) guides.barriers.push_back({mesh.from(h), mesh.to(h)});
  const Partition part = run(Surface(mesh, guides, job()), {.proxies = 4});
  EXPECT_EQ(part.parts_left_out, 0);
  EXPECT_EQ(std::count(part.face_region.begin(), part.face_region.end(), part.face_region[corner]), 1);
}

/// Regions most of whose faces lie above z = 0.
std::int32_t above(const Mesh& mesh, const Partition& part) {
  std::vector<double> sum(part.region_seed.size(), 0.0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t v : mesh.triangles()[f]) sum[part.face_region[f]] += mesh.vertices()[v].z();
  return static_cast<std::int32_t>(std::count_if(sum.begin(), sum.end(), [](double z) { return z > 0; }));
}

TEST(Weights, DrawRegionsToHighOnes) {
  const Mesh mesh = shapes::mesh(shapes::sphere(4));
  for (const Method method : {Method::hierarchy, Method::teleport, Method::lloyd}) {
    std::vector<std::int32_t> counts;
    for (const double weight : {0.0, 0.25, 1.0, 4.0, 16.0}) {
      Guides guides;
      for (const Triangle& t : mesh.triangles()) guides.weights.push_back(mesh.vertices()[t[0]].z() > 0 ? weight : 1.0);
      const Partition part = run(Surface(mesh, guides, job()), {.proxies = 100, .method = method});
      EXPECT_EQ(part.region_count(), 100);
      counts.push_back(above(mesh, part));
    }
    EXPECT_TRUE(std::is_sorted(counts.begin(), counts.end(), std::less_equal<>())) << ::testing::PrintToString(counts);
    EXPECT_NEAR(counts[2], 50, 8);
    EXPECT_NEAR(counts[4], 80, 8);  // a density of 4 against 1
  }
}

TEST(Weights, AllAlikeChangeNothing) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(40, 20), 0.02, 3));
  const Guides guides{std::vector<double>(static_cast<std::size_t>(mesh.face_count()), 4.0), {}};
  const Partition plain = run(mesh, {.proxies = 30}), weighted = run(Surface(mesh, guides, job()), {.proxies = 30});
  EXPECT_EQ(plain.face_region, weighted.face_region);
  EXPECT_NEAR(weighted.error / plain.error, 4.0, 1e-6);
}

}  // namespace
}  // namespace isimp
