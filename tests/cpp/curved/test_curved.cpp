#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/curved/edit_round.h"
#include "isimp/curved/round.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/soundness.h"
#include "isimp/simplify/partitioner.h"
#include "shapes.h"

namespace isimp {
namespace {

constexpr int kRound = 96;  // faces round a solid of revolution

/// A closed solid of revolution round z: rings of vertices at (radius, height), and fans to the axis at both ends.
shapes::Arrays turned(const std::vector<std::array<double, 2>>& profile) {
  shapes::Arrays a;
  const auto at = [&](std::size_t ring, int k) { return static_cast<std::int32_t>(ring) * kRound + k % kRound; };
  for (const auto& [rho, z] : profile)
    for (int k = 0; k < kRound; ++k) {
      const double angle = 2 * std::numbers::pi * k / kRound;
      a.vertices.emplace_back(rho * std::cos(angle), rho * std::sin(angle), z);
    }
  for (std::size_t r = 0; r + 1 < profile.size(); ++r)
    for (int k = 0; k < kRound; ++k) {
      a.triangles.push_back({at(r, k), at(r, k + 1), at(r + 1, k + 1)});
      a.triangles.push_back({at(r, k), at(r + 1, k + 1), at(r + 1, k)});
    }
  const auto low = static_cast<std::int32_t>(a.vertices.size()), high = low + 1;
  a.vertices.emplace_back(0, 0, profile.front()[1]);
  a.vertices.emplace_back(0, 0, profile.back()[1]);
  for (int k = 0; k < kRound; ++k) {
    a.triangles.push_back({low, at(0, k + 1), at(0, k)});
    a.triangles.push_back({high, at(profile.size() - 1, k), at(profile.size() - 1, k + 1)});
  }
  return a;
}

/// A can of radius 1, its lids of rings, so that no triangle is a needle.
shapes::Arrays can(double upper = 1.0) {
  std::vector<std::array<double, 2>> profile;
  for (int k = 1; k < 8; ++k) profile.push_back({k / 8.0, -1.5});
  for (int k = 0; k <= 40; ++k) profile.push_back({1 + (upper - 1) * k / 40.0, -1.5 + 3 * k / 40.0});
  for (int k = 7; k > 0; --k) profile.push_back({upper * k / 8.0, 1.5});
  return turned(profile);
}

Partition split(const Mesh& mesh, bool curved, double noise = 0) {
  PartitionOptions options{.detail = 0.005, .noise = noise};
  options.curved = curved;
  Job job;
  return Partitioner(mesh).run(options, {}, job);
}

std::int64_t cells(const Partition& part, std::int32_t proxy) {
  return std::count_if(part.region_cell.begin(), part.region_cell.end(),
                       [&](const CurvedCell& c) { return c.proxy == proxy; });
}

/// A face in the first cell of the first patch.
std::int32_t face_of_patch(const Partition& part) {
  for (std::int32_t r = 0; r < part.region_count(); ++r)
    if (part.region_cell[r].proxy == 0) return part.region_seed[r];
  return kNone;
}

TEST(Curved, ACanIsAPrismWithItsAxisAndRadius) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  ASSERT_EQ(part.curved.size(), 1U);
  const CurvedProxy& c = part.curved[0];
  EXPECT_EQ(c.kind, CurvedKind::cylinder);
  EXPECT_NEAR(std::abs(c.axis.z()), 1, 1e-6);
  EXPECT_NEAR(c.radius, 1, 0.002);
  EXPECT_NEAR(c.point.head<2>().norm(), 0, 1e-3);
  EXPECT_TRUE(c.full);
  EXPECT_EQ(c.rings, 1);
  EXPECT_EQ(cells(part, 0), c.segments);
  EXPECT_EQ(part.region_count(), c.segments + 2);
  EXPECT_EQ(broken_promise(mesh, part), "");
}

TEST(Curved, ItsPolygonsAreEqualQuads) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  Job job;
  const PolygonMesh poly = polygonize(mesh, part, {}, job);
  std::vector<double> areas;
  for (std::size_t q = 0; q < poly.loop_start.size(); ++q) {
    if (part.region_cell[poly.polygon_region[q]].proxy == kNone) continue;
    const std::size_t end = q + 1 < poly.loop_start.size() ? poly.loop_start[q + 1] : poly.loops.size();
    ASSERT_EQ(end - poly.loop_start[q], 4U);
    const auto p = [&](int k) { return poly.vertices[poly.loops[poly.loop_start[q] + k]]; };
    areas.push_back((p(2) - p(0)).cross(p(3) - p(1)).norm() / 2);
  }
  const auto [least, most] = std::minmax_element(areas.begin(), areas.end());
  EXPECT_LT(*most / *least, 1.05);
  EXPECT_TRUE(poly.planes_let_go.empty());
}

TEST(Curved, AConeIsFound) {
  const Mesh mesh = shapes::mesh(can(0.4));
  const Partition part = split(mesh, true);
  ASSERT_EQ(part.curved.size(), 1U);
  EXPECT_EQ(part.curved[0].kind, CurvedKind::cone);
  EXPECT_NEAR(std::abs(part.curved[0].slope), 0.6 / 3, 0.002);
}

TEST(Curved, NoiseLeavesAxisAndRadius) {
  const Mesh mesh = shapes::mesh(shapes::noisy(can(), 0.004, 5));
  const Partition part = split(mesh, true, 0.004);
  ASSERT_EQ(part.curved.size(), 1U);
  EXPECT_NEAR(part.curved[0].radius, 1, 0.005);
  EXPECT_LT(std::acos(std::min(1.0, std::abs(part.curved[0].axis.z()))), 0.1 * std::numbers::pi / 180);
}

TEST(Curved, FreeFormsStayBitByBit) {
  shapes::Arrays figure = shapes::sphere(4);
  for (Vec3& v : figure.vertices)
    v *= 1 + 0.25 * std::sin(5 * v[1] + 1) * std::cos(4 * v[0]) + 0.2 * std::sin(3 * v[2] + 2 * v[1]) * v[0] * v[0];
  const Mesh mesh = shapes::mesh(figure);
  const Partition plain = split(mesh, false), round = split(mesh, true);
  EXPECT_TRUE(round.curved.empty());
  EXPECT_EQ(plain.face_region, round.face_region);
  EXPECT_TRUE(round.region_held.empty());
}

TEST(Curved, AnyNumberOfThreadsGivesTheSame) {
  const Mesh mesh = shapes::mesh(shapes::noisy(can(0.6), 0.003, 2));
  PartitionOptions options{.detail = 0.005};
  options.curved = true;
  std::vector<Partition> parts;
  for (const int threads : {1, 3}) {
    options.threads = threads;
    Job job;
    parts.push_back(Partitioner(mesh).run(options, {}, job));
  }
  EXPECT_EQ(parts[0].face_region, parts[1].face_region);
  EXPECT_EQ(parts[0].curved, parts[1].curved);
  EXPECT_EQ(parts[0].region_normal, parts[1].region_normal);
}

TEST(Curved, ABoundAndSymmetryAreRefused) {
  const Mesh mesh = shapes::mesh(can());
  Job job;
  PartitionOptions bound{.bound = 0.1}, mirrored{.symmetry = Symmetry::x};
  bound.curved = mirrored.curved = true;
  EXPECT_THROW(Partitioner(mesh).run(bound, {}, job), InvalidInput);
  EXPECT_THROW(Partitioner(mesh).run(mirrored, {}, job), InvalidInput);
}

TEST(Curved, SegmentsChangeOnePatchOnly) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  Job job;
  const Partition more = with_segments(mesh, part, face_of_patch(part), 20, 0, job);
  ASSERT_EQ(more.curved.size(), 1U);
  EXPECT_EQ(more.curved[0].segments, 20);
  EXPECT_EQ(cells(more, 0), 20);
  EXPECT_EQ(more.region_count(), 22);
  EXPECT_EQ(more.curved[0].radius, part.curved[0].radius);
  EXPECT_EQ(broken_promise(mesh, more), "");
  EXPECT_THROW(with_segments(mesh, part, face_of_patch(part), 2, 0, job), InvalidInput);
}

TEST(Curved, ExplodedCellsKeepTheirLabels) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  Job job;
  const std::int32_t face = face_of_patch(part);
  const Partition loose = explode_round(mesh, part, face, job);
  EXPECT_EQ(loose.face_region, part.face_region);
  EXPECT_TRUE(loose.curved.empty());
  EXPECT_FALSE(loose.is_held(loose.face_region[face]));
  EXPECT_THROW(explode_round(mesh, loose, face, job), InvalidInput);
}

TEST(Curved, LockedCellsAreNotCutAgain) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  Job job;
  const std::vector<std::int32_t> face = {face_of_patch(part)};
  const Partition locked = set_locked(mesh, part, face, true);
  EXPECT_THROW(with_segments(mesh, locked, face[0], 20, 0, job), InvalidInput);
  EXPECT_THROW(explode_round(mesh, locked, face[0], job), InvalidInput);
}

TEST(Curved, ACellThatAnEditChangesLeavesItsPatch) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  Job job;
  const Partition fewer = delete_proxy(mesh, part, face_of_patch(part), job);
  EXPECT_LT(cells(fewer, 0), cells(part, 0) - 1);  // the deleted cell, and those that took its faces
  EXPECT_GT(cells(fewer, 0), 0);
  EXPECT_EQ(broken_promise(mesh, fewer), "");
}

TEST(Curved, RegionsMadeRoundAreOnePatch) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, false);
  std::vector<std::int32_t> side;
  for (std::int32_t r = 0; r < part.region_count(); ++r)
    if (std::abs(part.region_normal[r].z()) < 0.5) side.push_back(part.region_seed[r]);
  Job job;
  const Partition round = make_round(mesh, part, side, std::nullopt, job);
  ASSERT_EQ(round.curved.size(), 1U);
  EXPECT_EQ(round.curved[0].kind, CurvedKind::cylinder);
  EXPECT_NEAR(round.curved[0].radius, 1, 0.002);
  EXPECT_LE(std::abs(round.region_count() - part.region_count()), 1);
  EXPECT_THROW(make_round(mesh, part, {}, std::nullopt, job), InvalidInput);
}

}  // namespace
}  // namespace isimp
