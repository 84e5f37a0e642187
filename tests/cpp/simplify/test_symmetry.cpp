#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/soundness.h"
#include "isimp/simplify/mirror.h"
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "shapes.h"

namespace isimp {
namespace {

/// A bumpy figure that mirrors across X except for noise, and `lump` on one side. Its triangles do not mirror.
shapes::Arrays figure(double noise = 0.002, double lump = 0, double width = 0.35, int levels = 4) {
  shapes::Arrays a = shapes::sphere(levels);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& v : a.vertices) {
    v = turn * v;
    const double x = v[0], y = v[1], z = v[2];
    const double bumps = 0.25 * std::sin(5 * y + 1) * std::cos(4 * x) + 0.2 * std::sin(3 * z + 2 * y) * x * x;
    v *= 1 + bumps + lump * std::exp(-(v - Vec3(0.7, 0.5, 0.5)).squaredNorm() / (width * width));
    v[1] *= 1.3;
    v[2] *= 0.8;
  }
  return shapes::noisy(a, noise, 3);
}

/// Turned and moved, so that no axis is across its plane.
shapes::Arrays turned(shapes::Arrays a, const Eigen::Matrix3d& by, const Vec3& to) {
  for (Vec3& v : a.vertices) v = by * v + to;
  return a;
}

Partition split(const Mesh& mesh, const PartitionOptions& options) {
  Job job;
  return Partitioner(mesh).run(options, {}, job);
}

PolygonMesh meshed(const Mesh& mesh, const Partition& partition, std::int32_t threads = 1) {
  Job job;
  return polygonize(mesh, partition, {.threads = threads}, job);
}

/// Shapes without area, or with two sides in one place: none of them may end the program.
TEST(Symmetry, FlatAndDegenerateShapes) {
  const shapes::Arrays ball = shapes::sphere(2);
  for (const Vec3& by :
       {Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(1, 1e-9, 1e-9), Vec3(1e-200, 1e-200, 1e-200)}) {
    shapes::Arrays flat = ball;
    for (Vec3& v : flat.vertices) v = v.cwiseProduct(by);
    const Mesh mesh = shapes::mesh(flat);
    for (int k = 0; k < 8; ++k) {
      const auto symmetry = static_cast<Symmetry>(1 + k % 4);
      try {
        const Partition p = split(mesh, {.proxies = k < 4 ? 10 : 1, .symmetry = symmetry});
        EXPECT_EQ(broken_promise(mesh, p), "");
        EXPECT_EQ(std::ranges::count(p.face_region, kNone), 0);
      } catch (const InvalidInput& e) {
        EXPECT_NE(symmetry, Symmetry::found) << e.what();
      }
    }
  }
}

TEST(Symmetry, FindsAnObliquePlane) {
  Job job;
  const Eigen::Matrix3d by = Eigen::AngleAxisd(0.5, Vec3(1, -1, 2).normalized()).toRotationMatrix();
  const Vec3 to(3, -2, 1);
  const Mesh mesh = shapes::mesh(turned(figure(), by, to));
  const auto found = find_mirror(mesh, Symmetry::found, 0.02, 1, job);
  ASSERT_TRUE(found);
  const Vec3 normal = by * Vec3::UnitX();
  EXPECT_GT(std::abs(found->normal.dot(normal)), std::cos(0.3 * std::numbers::pi / 180));
  EXPECT_NEAR(found->height(to), 0, 0.005);
  EXPECT_LT(found->mismatch, 0.01);
  EXPECT_LT(found->mismatch_mean, found->mismatch);
}

TEST(Symmetry, IsTheSameOnAnyNumberOfThreads) {
  const Mesh mesh = shapes::mesh(figure());
  const PartitionOptions one{.proxies = 80, .symmetry = Symmetry::found, .threads = 1};
  PartitionOptions four = one;
  four.threads = 4;
  const Partition a = split(mesh, one), b = split(mesh, four);
  EXPECT_EQ(a.face_region, b.face_region);
  EXPECT_EQ(a.symmetry, b.symmetry);
  EXPECT_EQ(meshed(mesh, a, 1).vertices, meshed(mesh, b, 4).vertices);
}

TEST(Symmetry, IsNoneForAFigureWithALump) {
  Job job;
  const Mesh mesh = shapes::mesh(figure(0.002, 1.2));
  EXPECT_FALSE(find_mirror(mesh, Symmetry::found, 0.02, 1, job));
  const Partition plain = split(mesh, {.proxies = 300}),
                  found = split(mesh, {.proxies = 300, .symmetry = Symmetry::found});
  EXPECT_FALSE(found.symmetry);
  EXPECT_EQ(found.face_region, plain.face_region);
  const std::string why = checks::message_of([&] { (void)split(mesh, {.proxies = 300, .symmetry = Symmetry::y}); });
  EXPECT_NE(why.find("does not mirror across y"), std::string::npos) << why;
}

TEST(Symmetry, IsNotForABound) {
  const Mesh mesh = shapes::mesh(figure());
  EXPECT_THROW((void)split(mesh, {.bound = 0.1, .symmetry = Symmetry::x}), InvalidInput);
}

class SymmetricRegions : public testing::TestWithParam<std::int32_t> {};

TEST_P(SymmetricRegions, MirrorAndSoDoTheirCorners) {
  const Mesh mesh = shapes::mesh(figure(0.001, 0, 1, 5));
  const Partition part = split(mesh, {.proxies = GetParam(), .symmetry = Symmetry::x});
  checks::expect_sound_regions(mesh, part);
  EXPECT_EQ(part.region_count(), GetParam());
  ASSERT_TRUE(part.symmetry);
  EXPECT_GE(part.symmetry->regions, 0.9 * GetParam());
  const PolygonMesh polygons = meshed(mesh, part);
  EXPECT_GE(polygons.report.mirrored_corners, 0.8 * polygons.report.vertices);
  EXPECT_EQ(polygons.report.crossing + polygons.report.flipped + polygons.report.bent, 0);
  EXPECT_EQ(polygons.report.intersecting, 0);
}

TEST_P(SymmetricRegions, AreNearlyAsGoodAsOthers) {
  const Mesh mesh = shapes::mesh(figure(0.001, 0, 1, 5));
  const Partition plain = split(mesh, {.proxies = GetParam()});
  const Partition mirrored = split(mesh, {.proxies = GetParam(), .symmetry = Symmetry::x});
  EXPECT_LT(mirrored.error, 1.25 * plain.error);
}

INSTANTIATE_TEST_SUITE_P(Numbers, SymmetricRegions, testing::Values(20, 80, 201));

TEST(Symmetry, KeepsTheSixSidesOfACube) {
  const Mesh mesh = shapes::mesh(shapes::cube(8));
  const Partition part = split(mesh, {.proxies = 6, .symmetry = Symmetry::found});
  ASSERT_TRUE(part.symmetry);
  EXPECT_EQ(part.region_count(), 6);
  EXPECT_NEAR(part.error, 0, 1e-9);
  EXPECT_EQ(part.symmetry->regions, 6);
  const PolygonMesh polygons = meshed(mesh, part);
  EXPECT_EQ(polygons.report.vertices, 8);
  EXPECT_EQ(polygons.report.mirrored_corners, 8);
}

TEST(Symmetry, HoldsForANumberThatIsFound) {
  const Mesh mesh = shapes::mesh(figure());
  const Partition part = split(mesh, {.detail = 0.01, .symmetry = Symmetry::x}), plain = split(mesh, {.detail = 0.01});
  ASSERT_TRUE(part.symmetry);
  EXPECT_GT(part.tolerance, 0);
  EXPECT_GE(part.symmetry->regions, 0.9 * part.region_count());
  EXPECT_NEAR(part.region_count(), plain.region_count(), 0.25 * plain.region_count());
}

TEST(Symmetry, KeepsShapesOnOneSideOnly) {
  const Mesh mesh = shapes::mesh(figure(0.002, 0.5, 0.12));
  const Partition part = split(mesh, {.proxies = 60, .symmetry = Symmetry::x});
  checks::expect_sound_regions(mesh, part);
  ASSERT_TRUE(part.symmetry);
  EXPECT_LT(part.symmetry->regions, part.region_count());
  EXPECT_GE(part.symmetry->regions, 0.6 * part.region_count());
}

TEST(Symmetry, StaysWhenRegionsAreEdited) {
  Job job;
  const Mesh mesh = shapes::mesh(figure());
  const Partition part = split(mesh, {.proxies = 60, .symmetry = Symmetry::x});
  const Partition edited = add_proxy(mesh, part, 100, job);
  ASSERT_TRUE(edited.symmetry);
  EXPECT_EQ(edited.symmetry->normal, part.symmetry->normal);
  EXPECT_EQ(edited.symmetry->regions, kNone);
  const PolygonMesh before = meshed(mesh, part), after = meshed(mesh, edited);
  EXPECT_GT(after.report.mirrored_corners, before.report.mirrored_corners / 2);
}

TEST(Symmetry, KeepsLockedRegions) {
  Job job;
  const Mesh mesh = shapes::mesh(figure());
  const Partition before = set_locked(mesh, split(mesh, {.proxies = 60}), std::vector<std::int32_t>{100}, kLocked);
  const Partition part = Partitioner(mesh).run({.proxies = 60, .symmetry = Symmetry::x}, {.before = &before}, job);
  ASSERT_TRUE(part.symmetry);
  const std::int32_t old = before.face_region[100], now = part.face_region[100];
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    ASSERT_EQ(before.face_region[f] == old, part.face_region[f] == now) << f;
}

}  // namespace
}  // namespace isimp
