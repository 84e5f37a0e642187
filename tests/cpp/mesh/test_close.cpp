#include "cleaning/close.h"
#include "isimp/mesh/clean.h"
#include "mesh_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::repaired;
using shapes::Arrays;

Mesh closed(const Arrays& a, const CleanOptions& options) { return clean(a.vertices, a.triangles, options, job()); }

/// The faces for which `gone` is false.
template <class Gone>
Arrays without(Arrays a, Gone gone) {
  std::vector<Triangle> kept;
  for (const Triangle& t : a.triangles)
    if (!gone((a.vertices[t[0]] + a.vertices[t[1]] + a.vertices[t[2]]) / 3)) kept.push_back(t);
  a.triangles = kept;
  return a;
}

/// Two parallel unit squares, `gap` apart and joined by a tube of one cell in the middle of each: an open handle once
/// two tubes join them.
Arrays sheets_with_tubes(int n, double gap, const std::vector<std::pair<int, int>>& cells) {
  Arrays a = shapes::both(shapes::plane(n), shapes::plane(n), {0, 0, gap});
  const auto upper = static_cast<std::int32_t>(a.triangles.size() / 2);
  for (std::int32_t f = 0; f < upper; ++f) std::swap(a.triangles[f][1], a.triangles[f][2]);  // the lower one faces down
  const double cell = 1.0 / n;
  for (const auto& [i, j] : cells) {
    const double left = i * cell, low = j * cell;
    const auto inside = [&](const Vec3& c) {
      return c.x() > left && c.x() < left + cell && c.y() > low && c.y() < low + cell;
    };
    a = without(a, inside);
    const auto at = [&](int x, int y, double z) {
      for (std::size_t v = 0; v < a.vertices.size(); ++v)
        if ((a.vertices[v] - Vec3(x * cell, y * cell, z)).norm() < 1e-9) return static_cast<std::int32_t>(v);
      return kNone;
    };
    const std::pair<int, int> ring[] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
    for (int k = 0; k < 4; ++k) {
      const auto [x, y] = ring[k];
      const auto [u, w] = ring[(k + 1) % 4];
      const std::int32_t p = at(x, y, 0), q = at(u, w, 0), r = at(u, w, gap), s = at(x, y, gap);
      a.triangles.push_back({p, r, q});
      a.triangles.push_back({p, s, r});
    }
  }
  return a;
}

TEST(CloseHoles, OneInASphereIsCovered) {
  const Arrays open = without(shapes::sphere(3), [](const Vec3& c) { return c.z() > 0.95; });
  const Mesh before = closed(open, {}), after = closed(open, {.fill_holes = 3.0});
  ASSERT_EQ(before.report().border_loops, 1);
  EXPECT_TRUE(after.report().closed);
  EXPECT_EQ(after.report().euler, 2);
  EXPECT_EQ(repaired(after, "filled_holes"), 1);
  for (std::int32_t f = 0; f < after.face_count(); ++f)
    EXPECT_EQ(after.source_face()[f], f < before.face_count() ? f : kNone) << "face " << f;
}

TEST(CloseHoles, OneLongerThanTheLimitStaysOpen) {
  const Arrays open = without(shapes::sphere(3), [](const Vec3& c) { return c.z() > 0.95; });
  const Mesh mesh = closed(open, {.fill_holes = 1.0});
  EXPECT_EQ(mesh.report().border_loops, 1);
  EXPECT_EQ(repaired(mesh, "filled_holes"), 0);
}

TEST(CloseHoles, TheOutlineOfASheetIsNoHole) {
  const Arrays sheet = without(
      shapes::plane(9), [](const Vec3& c) { return std::abs(c.x() - 0.5) < 0.06 && std::abs(c.y() - 0.5) < 0.06; });
  const Mesh mesh = closed(sheet, {.fill_holes = 100.0});
  EXPECT_EQ(mesh.report().border_loops, 1);
  EXPECT_EQ(repaired(mesh, "filled_holes"), 1);
  EXPECT_NEAR(mesh.report().area, 1.0, 1e-12);
}

TEST(CloseHoles, AFaceAloneGetsNoBack) {
  for (const double height : {1.0, 0.0}) {
    const Mesh mesh = closed({{{0, 0, 0}, {1, 0, 0}, {2, height, 0}}, {{0, 1, 2}}}, {.fill_holes = 100.0});
    EXPECT_EQ(repaired(mesh, "filled_holes"), 0);
  }
}

TEST(CloseHoles, ALoopWhoseEndsMeetIsNoErrorOfCgal) {
  // CGAL takes such a loop for one that names its first vertex twice, and asserts the same of the points beyond.
  const std::vector<Vec3> loop = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  const std::vector<Vec3> beyond = {{0, -1, 0}, {2, 0, 0}, {1, 2, 0}, {-1, 1, 0}, {-1, -1, 0}};
  EXPECT_TRUE(detail::cover(loop, beyond, 0).triangles.empty());
  EXPECT_EQ(detail::cover(loop, beyond, 1).triangles.size(), 5U);
}

TEST(CloseHoles, AHoleIsCoveredThoughEveryCoverMeetsTheSurface) {
  // A needle stands in the hole: every cover cuts it.
  Arrays sheet = without(shapes::plane(9),
                         [](const Vec3& c) { return std::abs(c.x() - 0.5) < 0.06 && std::abs(c.y() - 0.5) < 0.06; });
  const auto n = static_cast<std::int32_t>(sheet.vertices.size());
  for (const Vec3& p : {Vec3(0.49, 0.497, -1), Vec3(0.51, 0.505, -1), Vec3(0.5, 0.5, 1)}) sheet.vertices.push_back(p);
  sheet.triangles.push_back({n, n + 1, n + 2});
  const Mesh mesh = closed(sheet, {.fill_holes = 1.0});
  EXPECT_EQ(repaired(mesh, "filled_holes"), 1);
  EXPECT_EQ(mesh.report().border_loops, 2);  // of the sheet and of the needle
}

// Both halves of a crown are images of each other, so several patches of it are equally good. The choice between them
// depended on the addresses of what CGAL allocates.
TEST(CloseHoles, OneOfSeveralEqualPatchesIsTakenWhereverMemoryIsFree) {
  const auto crown = [](int n) {
    std::vector<Vec3> loop, beyond;
    for (int i = 0; i < n; ++i) {
      const double turn = 2 * 3.14159265358979 * i / n, x = std::cos(turn), y = std::sin(turn);
      loop.emplace_back(std::round(8 * x), std::round(8 * y), i % 2);
      beyond.emplace_back(std::round(9 * x), std::round(9 * y), i % 2);
    }
    return detail::cover(loop, beyond, 0).triangles;
  };
  std::mt19937 random(1);
  for (int n = 8; n < 24; ++n) {
    const auto first = crown(n);
    for (int i = 0; i < 8; ++i) {
      std::vector<std::vector<char>> taken;
      for (int k = 0; k < 200; ++k) taken.emplace_back(random() % 8000);
      std::shuffle(taken.begin(), taken.end(), random);
      taken.resize(100);
      EXPECT_EQ(crown(n), first) << n;
    }
  }
}

TEST(CutHandles, ASmallOneIsCutAndALargeOneStays) {
  const Arrays ring = shapes::torus(48, 24, 0.4);  // around its tube: 2.5; around the hole inside: 3.8
  const Mesh kept = closed(ring, {.cut_handles = 2.0}), cut = closed(ring, {.cut_handles = 3.0});
  EXPECT_EQ(kept.report().euler, 0);
  EXPECT_EQ(repaired(kept, "cut_handles"), 0);
  EXPECT_EQ(cut.report().euler, 2);
  EXPECT_TRUE(cut.report().closed);
  EXPECT_EQ(cut.component_count(), 1);
  EXPECT_EQ(repaired(cut, "cut_handles"), 1);
}

TEST(CutHandles, OneOfTwoTubesBetweenSheetsIsCut) {
  const Arrays sheets = sheets_with_tubes(20, 0.2, {{4, 4}, {14, 12}});
  const Mesh before = closed(sheets, {});
  ASSERT_EQ(before.component_count(), 1);
  ASSERT_EQ(before.report().border_loops, 2);
  ASSERT_EQ(before.report().euler, -2);
  // Either tube closes the handle; once one is removed, the other joins two sheets and is no handle any more.
  const Mesh after = closed(sheets, {.cut_handles = 0.5});
  EXPECT_EQ(repaired(after, "cut_handles"), 1);
  EXPECT_EQ(after.component_count(), 1);
  EXPECT_EQ(after.report().border_loops, 2);
  EXPECT_EQ(after.report().euler, 0);
}

TEST(CloseHoles, LengthsAreChecked) {
  for (const CleanOptions& bad : {CleanOptions{.fill_holes = -1}, CleanOptions{.cut_handles = std::nan("")}})
    EXPECT_THROW(closed(shapes::cube(), bad), InvalidInput);
}

}  // namespace
}  // namespace isimp
