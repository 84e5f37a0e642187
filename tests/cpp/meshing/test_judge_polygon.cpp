// Polygons of many corners: the edges that are found to cross against all pairs of edges.
#include "judge/judge.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

std::int64_t turn(const Vec3& a, const Vec3& b, const Vec3& c) {
  return static_cast<std::int64_t>((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
}

/// Whether two edges that do not follow each other have a point in common; coordinates are whole numbers.
bool touch(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto sign = [](std::int64_t x) { return (x > 0) - (x < 0); };
  const auto on = [](const Vec3& p, const Vec3& q, const Vec3& x) {
    return turn(p, q, x) == 0 && (x - p).dot(x - q) <= 0;
  };
  if (sign(turn(a, b, c)) * sign(turn(a, b, d)) < 0 && sign(turn(c, d, a)) * sign(turn(c, d, b)) < 0) return true;
  return on(a, b, c) || on(a, b, d) || on(c, d, a) || on(c, d, b);
}

bool crosses(const std::vector<Vec3>& p) {
  const auto n = static_cast<std::int32_t>(p.size());
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = i + 2; j < n; ++j)
      if ((i > 0 || j < n - 1) && touch(p[i], p[i + 1], p[j], p[(j + 1) % n])) return true;
  return false;
}

/// A star whose corners lie on whole numbers; some change places.
std::vector<Vec3> star(int corners, int swaps, std::mt19937& random) {
  std::vector<Vec3> p;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    const double radius = 4000 + static_cast<double>(random() % 4000);
    p.emplace_back(std::round(radius * std::cos(angle)), std::round(3 * radius * std::sin(angle)), 0);
  }
  for (int i = 0; i < swaps; ++i) {
    const std::size_t at = random() % (p.size() - 1);
    std::swap(p[at], p[at + 1]);
  }
  return p;
}

TEST(JudgePolygon, FindsWhetherManyEdgesCross) {
  std::mt19937 random(7);
  int crossed = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<Vec3> p = star(20 + static_cast<int>(random() % 100), trial % 3, random);
    std::vector<std::int32_t> polygon(p.size());
    std::iota(polygon.begin(), polygon.end(), 0);
    FlatView view;
    const PolygonDefects found = judge_polygon(polygon, p, Vec3::UnitZ(), {0, 1e-3}, &view);
    const bool expected = crosses(p);
    ASSERT_EQ((found.kinds & kCrossing) != 0, expected) << trial;
    ASSERT_EQ(found.crossing[0] >= 0, expected) << trial;
    crossed += expected;
    ASSERT_EQ(view == nullptr, expected) << trial;
    if (!expected) {
      std::vector<Facet> facets;
      triangulate(*view, polygon, p, {0, 1e-3}, {}, facets);
      ASSERT_EQ(facets.size(), p.size() - 2) << trial;
      std::int64_t area = 0, sum = 0;  // twice
      for (std::size_t i = 0; i < p.size(); ++i) area += turn(Vec3::Zero(), p[i], p[(i + 1) % p.size()]);
      for (const Facet& facet : facets) {
        const auto& [a, b, c] = facet.corner;
        ASSERT_GE(turn(p[a], p[b], p[c]), 0) << trial;
        sum += turn(p[a], p[b], p[c]);
      }
      ASSERT_EQ(sum, area) << trial;
    }
  }
  EXPECT_GT(crossed, 20);
  EXPECT_LT(crossed, 180);
}

/// The defects of a polygon in the plane z = 0, with a thickness of .001.
std::uint8_t kinds_of(const std::vector<Vec3>& p) {
  std::vector<std::int32_t> polygon(p.size());
  std::iota(polygon.begin(), polygon.end(), 0);
  return judge_polygon(polygon, p, Vec3::UnitZ(), {0, 1e-3}, nullptr).kinds;
}

TEST(JudgePolygon, ACornerNearerToAnEdgeThanTheThicknessTouchesIt) {
  for (const double gap : {1e-9, 1e-4, -1e-9}) {
    EXPECT_EQ(kinds_of({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, gap, 0}, {0, 4, 0}}), kCrossing) << gap;
    EXPECT_EQ(kinds_of({{0, 0, 0}, {4, 0, 0}, {2, gap, 0}, {4, 4, 0}, {0, 4, 0}}), kCrossing) << "a fold of " << gap;
  }
  EXPECT_EQ(kinds_of({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0.01, 0}, {0, 4, 0}}), 0);
  EXPECT_EQ(kinds_of({{0, 0, 0}, {4, 0, 0}, {2, 0.01, 0}, {4, 4, 0}, {0, 4, 0}}), 0);
}

TEST(JudgePolygon, AnEdgeShorterThanTheThicknessIsNoTouch) {
  EXPECT_EQ(kinds_of({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 3, 0}, {2, 3.0001, 0}, {0, 4, 0}}), 0);
}

}  // namespace
}  // namespace isimp::meshing
