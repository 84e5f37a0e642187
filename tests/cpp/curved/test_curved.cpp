#include "isimp/curved/edit_round.h"
#include "isimp/curved/round.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/soundness.h"
#include "isimp/simplify/partitioner.h"
#include "tests.h"

namespace isimp {
namespace {

constexpr int kRound = 96;  // faces around a solid of revolution

using Outline = std::vector<std::array<double, 2>>;

Outline circle() {
  Outline round;
  for (int k = 0; k < kRound; ++k) {
    const double angle = 2 * std::numbers::pi * k / kRound;
    round.push_back({std::cos(angle), std::sin(angle)});
  }
  return round;
}

/// A rectangle with round corners, its points about equally far apart.
Outline rounded(double half_x, double half_y, double radius) {
  Outline all;
  const double x = half_x - radius, y = half_y - radius, length = 4 * (x + y) + 2 * std::numbers::pi * radius;
  for (int k = 0; k < kRound; ++k) {
    double at = length * k / kRound;
    for (int side = 0; side < 4; ++side) {
      const double straight = side % 2 == 0 ? 2 * y : 2 * x, arc = std::numbers::pi / 2 * radius;
      const std::array<double, 2> out = {std::array{1., 0., -1., 0.}[side], std::array{0., 1., 0., -1.}[side]};
      const double cx = out[0] * x - out[1] * x, cy = out[1] * y + out[0] * y;  // of the corner after the side
      if (at < straight) {
        all.push_back(
            {cx + radius * out[0] + (straight - at) * out[1], cy + radius * out[1] - (straight - at) * out[0]});
        break;
      }
      if ((at -= straight) < arc) {
        const double c = std::cos(at / radius), s = std::sin(at / radius);
        all.push_back({cx + radius * (c * out[0] - s * out[1]), cy + radius * (c * out[1] + s * out[0])});
        break;
      }
      at -= arc;
    }
  }
  return all;
}

/// A closed solid round z: rings of vertices at (factor of the outline, height), and fans to the axis at both ends.
shapes::Arrays turned(const std::vector<std::array<double, 2>>& profile, const Outline& outline = circle()) {
  shapes::Arrays a;
  const auto at = [&](std::size_t ring, int k) { return static_cast<std::int32_t>(ring) * kRound + k % kRound; };
  for (const auto& [rho, z] : profile)
    for (const auto& [x, y] : outline) a.vertices.emplace_back(rho * x, rho * y, z);
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
shapes::Arrays can(double upper = 1.0, const Outline& outline = circle()) {
  std::vector<std::array<double, 2>> profile;
  for (int k = 1; k < 8; ++k) profile.push_back({k / 8.0, -1.5});
  for (int k = 0; k <= 40; ++k) profile.push_back({1 + (upper - 1) * k / 40.0, -1.5 + 3 * k / 40.0});
  for (int k = 7; k > 0; --k) profile.push_back({upper * k / 8.0, 1.5});
  return turned(profile, outline);
}

/// A can with a roof: a cone without its tip, which meets the cylinder at 37 degrees.
shapes::Arrays silo() {
  std::vector<std::array<double, 2>> profile;
  for (int k = 1; k < 8; ++k) profile.push_back({k / 8.0, -2});
  for (int k = 0; k <= 40; ++k) profile.push_back({1, -2 + 3 * k / 40.0});
  for (int k = 1; k < 18; ++k) profile.push_back({1 - k / 20.0, 1 + 0.75 * k / 20.0});
  return turned(profile);
}

Partition split(const Mesh& mesh, bool curved, double noise = 0) {
  PartitionOptions options{.detail = 0.005, .noise = noise};
  options.curved = curved;
  return Partitioner(mesh).run(options, {}, job());
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
  const PolygonMesh poly = polygonize(mesh, part, {}, job());
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

TEST(Curved, ASiloIsACylinderAndACone) {
  for (const double noise : {0.0, 0.003, 0.01}) {
    const Mesh mesh = shapes::mesh(noise > 0 ? shapes::noisy(silo(), noise, 3) : silo());
    const Partition part = split(mesh, true, noise);
    ASSERT_EQ(part.curved.size(), 2U) << noise;
    const auto is_cone = [](const CurvedProxy& p) { return p.kind == CurvedKind::cone; };
    const CurvedProxy& roof = part.curved[is_cone(part.curved[0]) ? 0 : 1];
    const CurvedProxy& wall = part.curved[is_cone(part.curved[0]) ? 1 : 0];
    EXPECT_EQ(roof.kind, CurvedKind::cone);
    EXPECT_EQ(wall.kind, CurvedKind::cylinder);
    EXPECT_NEAR(wall.radius, 1, 0.005);
    EXPECT_NEAR(std::abs(roof.slope), 1 / 0.75, 0.03);
    EXPECT_LT(roof.axis.cross(wall.axis).norm(), 1e-12);  // cut together, about one axis
    EXPECT_LT((roof.point - wall.point).cross(wall.axis).norm(), 1e-9);
  }
}

TEST(Curved, HalfCylindersEndAtThePlanesThatTouchThem) {
  for (const double noise : {0.003, 0.012}) {
    const Mesh mesh = shapes::mesh(shapes::noisy(can(1, rounded(2, 1, 1)), noise, 3));
    const Partition part = split(mesh, true, noise);
    ASSERT_EQ(part.curved.size(), 2U) << noise;
    for (const CurvedProxy& p : part.curved) {
      EXPECT_EQ(p.kind, CurvedKind::cylinder);
      EXPECT_NEAR(p.radius, 1, 0.01);
      const double width = p.span / p.segments;
      EXPECT_NEAR(width * (p.segments + 1), std::numbers::pi, 0.02);  // the planes have half a segment each
    }
  }
}

/// A pipe of radius 0.5 along z, a quarter of a turn of radius 1.5, and a pipe along x: rings of vertices along its spine.
shapes::Arrays elbow() {
  constexpr int kAlong = 60, kAround = 48;
  constexpr double kBend = 1.5, kLeg = 2, kTube = 0.5;
  const double arc = kBend * std::numbers::pi / 2;
  shapes::Arrays a;
  for (int i = 0; i <= kAlong; ++i) {
    const double s = (2 * kLeg + arc) * i / kAlong, turn = std::clamp((s - kLeg) / kBend, 0.0, std::numbers::pi / 2);
    const Vec3 out(std::cos(turn), 0, std::sin(turn));  // from the axis of the bend
    const Vec3 spine =
        kBend * out + std::min(s - kLeg, 0.0) * Vec3::UnitZ() - std::max(s - kLeg - arc, 0.0) * Vec3::UnitX();
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2 * std::numbers::pi * k / kAround;
      a.vertices.push_back(spine + kTube * (std::cos(angle) * out + std::sin(angle) * Vec3::UnitY()));
    }
  }
  for (std::int32_t i = 0; i < kAlong; ++i)
    for (std::int32_t k = 0; k < kAround; ++k) {
      const std::int32_t p = i * kAround + k, q = i * kAround + (k + 1) % kAround;
      a.triangles.push_back({p, p + kAround, q});
      a.triangles.push_back({q, p + kAround, q + kAround});
    }
  return a;
}

TEST(Curved, ABendHasTheSegmentsOfItsPipes) {
  for (const std::uint32_t seed : {3U, 4U}) {
    const Mesh mesh = shapes::mesh(shapes::noisy(elbow(), 0.01, seed));
    const Partition part = split(mesh, true, 0.01);
    ASSERT_EQ(part.curved.size(), 3U);
    std::int32_t bends = 0;
    for (const CurvedProxy& p : part.curved) {
      const bool is_bend = p.kind == CurvedKind::revolution;
      bends += is_bend;
      EXPECT_EQ(is_bend ? p.rings : p.segments,
                part.curved[0].kind == CurvedKind::revolution ? part.curved[0].rings : part.curved[0].segments);
      EXPECT_LT(is_bend ? std::acos(std::min(1.0, std::abs(p.axis.y()))) : 0.0, 0.5 * std::numbers::pi / 180);
    }
    EXPECT_EQ(bends, 1);
    EXPECT_EQ(broken_promise(mesh, part), "");
  }
}

TEST(Curved, AnOvalCanIsAnExtrusion) {
  Outline oval = circle();
  for (auto& [x, y] : oval) x *= 2;
  const Mesh mesh = shapes::mesh(shapes::noisy(can(1, oval), 0.004, 3));
  const Partition part = split(mesh, true, 0.004);
  ASSERT_EQ(part.curved.size(), 1U);
  const CurvedProxy& p = part.curved[0];
  EXPECT_EQ(p.kind, CurvedKind::extrusion);
  EXPECT_TRUE(p.full);
  EXPECT_GT(std::abs(p.axis.z()), 1 - 1e-5);
  EXPECT_EQ(cells(part, 0), p.segments);
  for (std::size_t k = 1; k < p.knots.size(); ++k) EXPECT_LT(p.knots[k - 1], p.knots[k]);
  EXPECT_EQ(broken_promise(mesh, part), "");
}

TEST(Curved, ThinPinsStayPlanes) {  // three planes serve them, and a ring would be six
  const Mesh mesh = shapes::mesh(can());
  PartitionOptions options{.proxies = 5};
  options.curved = true;
  EXPECT_TRUE(Partitioner(mesh).run(options, {}, job()).curved.empty());
}

TEST(Curved, WhatIsKeptFromEarlierMakesNoDifference) {
  const Mesh mesh = shapes::mesh(shapes::noisy(can(), 0.004, 5));
  PartitionOptions plain{.detail = 0.005}, round = plain, other{.detail = 0.02};
  round.curved = true;
  const Partition fresh = Partitioner(mesh).run(round, {}, job());
  const Partitioner used(mesh);
  (void)used.run(plain, {}, job());
  const Partition again = used.run(round, {}, job());
  (void)used.run(other, {}, job());
  EXPECT_EQ(again.face_region, fresh.face_region);
  EXPECT_EQ(used.run(round, {}, job()).face_region, fresh.face_region);
  ASSERT_FALSE(fresh.curved.empty());
}

TEST(Curved, AFilletIsOneStripBetweenItsPlanes) {
  const Mesh mesh = shapes::mesh(can(1, rounded(2, 1.5, 0.4)));
  PartitionOptions options{.proxies = 10};
  options.curved = true;
  const Partition part = Partitioner(mesh).run(options, {}, job());
  ASSERT_EQ(part.curved.size(), 4U);
  for (const CurvedProxy& p : part.curved) {
    EXPECT_NEAR(p.radius, 0.4, 0.006);  // an arc of few faces
    EXPECT_EQ(p.segments, 1);
    EXPECT_NEAR(p.span, std::numbers::pi / 4, 0.01);
  }
  EXPECT_EQ(part.region_count(), 10);
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
    parts.push_back(Partitioner(mesh).run(options, {}, job()));
  }
  EXPECT_EQ(parts[0].face_region, parts[1].face_region);
  EXPECT_EQ(parts[0].curved, parts[1].curved);
  EXPECT_EQ(parts[0].region_normal, parts[1].region_normal);
}

TEST(Curved, ABoundIsRefused) {
  const Mesh mesh = shapes::mesh(can());
  PartitionOptions bound{.bound = 0.1};
  bound.curved = true;
  EXPECT_THROW((void)Partitioner(mesh).run(bound, {}, job()), InvalidInput);
}

TEST(Curved, SegmentsChangeOnePatchOnly) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  const Partition more = with_segments(mesh, part, face_of_patch(part), 20, 0, job());
  ASSERT_EQ(more.curved.size(), 1U);
  EXPECT_EQ(more.curved[0].segments, 20);
  EXPECT_EQ(cells(more, 0), 20);
  EXPECT_EQ(more.region_count(), 22);
  EXPECT_EQ(more.curved[0].radius, part.curved[0].radius);
  EXPECT_EQ(broken_promise(mesh, more), "");
  EXPECT_THROW(with_segments(mesh, part, face_of_patch(part), 2, 0, job()), InvalidInput);
}

TEST(Curved, ExplodedCellsKeepTheirLabels) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  const std::int32_t face = face_of_patch(part);
  const Partition loose = explode_round(mesh, part, face, job());
  EXPECT_EQ(loose.face_region, part.face_region);
  EXPECT_TRUE(loose.curved.empty());
  EXPECT_FALSE(loose.is_held(loose.face_region[face]));
  EXPECT_THROW(explode_round(mesh, loose, face, job()), InvalidInput);
  Partition regular = part;
  regular.regularity.emplace();
  EXPECT_FALSE(explode_round(mesh, regular, face, job()).regularity);
}

TEST(Curved, LockedCellsAreNotCutAgain) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  const std::vector<std::int32_t> face = {face_of_patch(part)};
  const Partition locked = set_locked(mesh, part, face, kLocked);
  EXPECT_THROW(with_segments(mesh, locked, face[0], 20, 0, job()), InvalidInput);
  EXPECT_THROW(explode_round(mesh, locked, face[0], job()), InvalidInput);
}

TEST(Curved, ACellThatAnEditChangesLeavesItsPatch) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, true);
  const Partition fewer = delete_proxy(mesh, part, face_of_patch(part), job());
  EXPECT_LT(cells(fewer, 0), cells(part, 0) - 1);  // the deleted cell, and the cells to which its faces went
  EXPECT_GT(cells(fewer, 0), 0);
  EXPECT_EQ(broken_promise(mesh, fewer), "");
}

TEST(Curved, RegionsMadeRoundAreOnePatch) {
  const Mesh mesh = shapes::mesh(can());
  const Partition part = split(mesh, false);
  std::vector<std::int32_t> side;
  for (std::int32_t r = 0; r < part.region_count(); ++r)
    if (std::abs(part.region_normal[r].z()) < 0.5) side.push_back(part.region_seed[r]);
  const Partition round = make_round(mesh, part, side, std::nullopt, job());
  ASSERT_EQ(round.curved.size(), 1U);
  EXPECT_EQ(round.curved[0].kind, CurvedKind::cylinder);
  EXPECT_NEAR(round.curved[0].radius, 1, 0.002);
  EXPECT_LE(std::abs(round.region_count() - part.region_count()), 1);
  EXPECT_THROW(make_round(mesh, part, {}, std::nullopt, job()), InvalidInput);
}

}  // namespace
}  // namespace isimp
