#include "bound/bound.h"
#include "density/adaptivity.h"
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::Arrays;

Partition within(const Surface& surface, double bound) { return partition(surface, {.bound = bound}, job()); }

/// The largest distance of a face's corner from the plane of the face's region.
double farthest(const Mesh& mesh, const Partition& part) {
  double most = 0.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t v : mesh.triangles()[f])
      if (const std::int32_t r = part.face_region[f]; r != kNone)
        most = std::max(most, std::abs(part.region_normal[r].dot(mesh.vertices()[v]) - part.region_offset[r]));
  return most;
}

TEST(Bound, IsKeptAfterTheBordersHaveRelaxed) {
  const Arrays torus = shapes::noisy(shapes::torus(120, 60), 0.01, 3);
  for (const double bound : {0.02, 0.05, 0.2}) {
    const Mesh mesh = shapes::mesh(torus);
    const Partition part = within(mesh, bound);
    EXPECT_LE(farthest(mesh, part), bound * (1 + 1e-9));
    EXPECT_NEAR(farthest(mesh, part), part.distance_max, 1e-9);
    EXPECT_GT(part.distance_max, 0.7 * bound);
    checks::expect_sound_regions(mesh, part);
  }
}

TEST(Bound, FewerRegionsServeALargerOne) {
  const Mesh mesh = shapes::mesh(shapes::sphere(5));
  const std::int32_t fine = within(mesh, 0.01).region_count(), coarse = within(mesh, 0.04).region_count();
  // A cap of height 2 t has radius 2 sqrt(t): hexagons in such caps cover the sphere with 1.21 / t of them, and it
  // takes less than twice that.
  EXPECT_LT(fine, 1.95 * 1.21 / 0.01);
  EXPECT_NEAR(static_cast<double>(fine) / coarse, 4.0, 0.6);
}

TEST(Bound, TakesThePlaneThatFitsBestAndNotTheMeanOne) {
  // z = c (x^2 + y^2) over the triangle x + y < 1 lies between planes c / 2 apart, of slopes c; across the mean normal,
  // of slopes 2 c / 3, they are 5 c / 9 apart.
  constexpr int kCells = 24;
  constexpr double kBend = 0.1;
  Arrays bowl;
  std::vector<std::vector<std::int32_t>> at(kCells + 1, std::vector<std::int32_t>(kCells + 1));
  for (int i = 0; i <= kCells; ++i)
    for (int j = 0; i + j <= kCells; ++j) {
      const double x = static_cast<double>(i) / kCells, y = static_cast<double>(j) / kCells;
      at[i][j] = static_cast<std::int32_t>(bowl.vertices.size());
      bowl.vertices.emplace_back(x, y, kBend * (x * x + y * y));
    }
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; i + j < kCells; ++j) {
      bowl.triangles.push_back({at[i][j], at[i + 1][j], at[i][j + 1]});
      if (i + j + 1 < kCells) bowl.triangles.push_back({at[i + 1][j], at[i + 1][j + 1], at[i][j + 1]});
    }
  const Mesh mesh = shapes::mesh(bowl);
  EXPECT_EQ(within(mesh, 0.265 * kBend).region_count(), 1);
  EXPECT_GT(within(mesh, 0.24 * kBend).region_count(), 1);
}

TEST(Bound, FlatThingsNeedNoMoreThanTheirSides) {
  EXPECT_EQ(within(shapes::mesh(shapes::plane(20)), 0.001).region_count(), 1);
  EXPECT_EQ(within(shapes::mesh(shapes::cube(9)), 0.001).region_count(), 6);
  EXPECT_EQ(within(shapes::mesh(shapes::both(shapes::cube(9), shapes::cube(9), Vec3(3, 0, 0))), 0.01).region_count(),
            12);
  EXPECT_EQ(within(shapes::mesh(shapes::cube(1)), 0.001).region_count(), 6);
}

TEST(Bound, LeavesAClosedPartFourRegions) {
  EXPECT_EQ(within(shapes::mesh(shapes::sphere(3)), 100.0).region_count(), 4);
  // Sides at right angles are never one: no plane is near to both.
  EXPECT_EQ(within(shapes::mesh(shapes::cube(1)), 100.0).region_count(), 6);
}

TEST(Bound, KeepsBarriers) {
  const Mesh mesh = shapes::mesh(shapes::plane(8));
  Guides guides;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (std::abs(mesh.vertices()[mesh.from(h)].x() - 0.5) < 1e-9 &&
        std::abs(mesh.vertices()[mesh.to(h)].x() - 0.5) < 1e-9)
      guides.barriers.push_back({mesh.from(h), mesh.to(h)});
  EXPECT_EQ(within(Surface(mesh, guides, job()), 0.1).region_count(), 2);
}

TEST(Bound, IsTheSameOnEveryRunAndThreadCount) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(150, 80), 0.01, 4));
  const auto labels = [&](std::int32_t threads) {
    return partition(mesh, {.bound = 0.04, .threads = threads}, job()).face_region;
  };
  EXPECT_EQ(labels(1), labels(1));
  EXPECT_EQ(labels(1), labels(3));
}

/// A sheet that is flat on the left and has small waves on the right.
Arrays half_rough() {
  Arrays sheet = shapes::plane(80);
  for (Vec3& p : sheet.vertices)
    p.z() = p.x() < 0.5 ? 0.1 * p.x() * p.x() : 0.02 * std::sin(60 * p.x()) * std::sin(60 * p.y());
  return sheet;
}

TEST(Adaptivity, WeighsRoughPlacesMoreAndLeavesTheAreaAsItIs) {
  const Mesh mesh = shapes::mesh(half_rough());
  const std::vector<float> weight = adaptive_weights(mesh, 0.5, Threads(1), job());
  double left = 0, right = 0, total = 0;
  for (std::int32_t i = 0; i < mesh.face_count(); ++i) {
    const double x = mesh.vertices()[mesh.triangles()[mesh.graph().mesh_face[i]][0]].x();
    if (x < 0.4) left = std::max<double>(left, weight[i]);
    if (x > 0.6) right = std::max<double>(right, weight[i]);
    total += static_cast<double>(weight[i]) * mesh.graph().faces[i].area;
  }
  EXPECT_GT(right, 2 * left);
  EXPECT_NEAR(total, 1.0, 1e-5);
  for (const float w : adaptive_weights(shapes::mesh(shapes::plane(9)), 1.0, Threads(1), job())) EXPECT_EQ(w, 1.0F);
}

/// As above, with a bend on the left that needs regions too: where one region does for all of it, none can be moved.
Arrays bent_and_rough() {
  Arrays sheet = shapes::plane(80);
  for (Vec3& p : sheet.vertices)
    p.z() = p.x() < 0.5 ? 1.5 * std::pow(p.x() - 0.5, 2) : 0.004 * std::sin(60 * p.x()) * std::sin(60 * p.y());
  return sheet;
}

/// The number of regions with their centre on the right.
std::int32_t on_the_right(const Mesh& mesh, const Partition& part) {
  std::vector<double> x(part.region_seed.size(), 0.0), faces(part.region_seed.size(), 0.0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    ++faces[part.face_region[f]];
    for (const std::int32_t v : mesh.triangles()[f]) x[part.face_region[f]] += mesh.vertices()[v].x() / 3;
  }
  std::int32_t count = 0;
  for (std::size_t r = 0; r < x.size(); ++r) count += x[r] > 0.5 * faces[r];
  return count;
}

TEST(Adaptivity, MovesRegionsToRoughPlacesAndStatesPlainErrors) {
  const Mesh mesh = shapes::mesh(bent_and_rough());
  std::vector<std::int32_t> rough;
  for (const double a : {0.0, 0.5, 1.0}) {
    // By the error alone, since short borders move a few regions too.
    const Partition part = partition(mesh, {.proxies = 60, .adaptivity = a, .smooth = 0}, job());
    EXPECT_EQ(part.region_count(), 60);
    EXPECT_EQ(part.guided, nullptr);
    checks::expect_sound(mesh, part);
    rough.push_back(on_the_right(mesh, part));
  }
  EXPECT_LT(rough[0], rough[1]);
  EXPECT_LT(rough[0], rough[2]);
}

}  // namespace
}  // namespace isimp
