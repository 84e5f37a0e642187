#include "isimp/mesh/io.h"
#include "mesh_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::kHouse;

/// The sum of the triangles' areas; it is the polygon's own only if they don't overlap.
double total_area(const PolygonSoup& soup, const Triangulation& t) {
  double sum = 0;
  for (const auto& [a, b, c] : t.triangles)
    sum += (soup.vertices[b] - soup.vertices[a]).cross(soup.vertices[c] - soup.vertices[a]).norm() / 2;
  return sum;
}

Triangulation triangles_of(const PolygonSoup& soup) { return triangulate(soup, job()); }

TEST(Triangulate, EachPolygonGivesTwoTrianglesLessThanItsCorners) {
  const Triangulation t = triangles_of(kHouse);
  EXPECT_EQ(t.source_polygon, (std::vector<std::int32_t>{0, 0, 1, 2, 2}));
  EXPECT_NEAR(total_area(kHouse, t), 1 + std::hypot(0.5, 0.1) / 2 + 1, 1e-5);
}

TEST(Triangulate, TrianglesStayAsTheyAre) {
  const PolygonSoup soup{kHouse.vertices, {0, 1, 2, 2, 2, 1, 3, 0, 1}, {0, 3, 6}};  // the second one has no area
  const Triangulation t = triangles_of(soup);
  EXPECT_EQ(t.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 2, 1}, {3, 0, 1}}));
  EXPECT_EQ(t.source_polygon, (std::vector<std::int32_t>{0, 1, 2}));
}

TEST(Triangulate, TwoAndFourCornersAreNotTakenForTriangles) {
  const PolygonSoup soup{kHouse.vertices, {0, 1, 0, 1, 2, 3}, {0, 2}};
  const Triangulation t = triangles_of(soup);
  EXPECT_EQ(t.source_polygon, (std::vector<std::int32_t>{1, 1}));
  EXPECT_NEAR(total_area(soup, t), 1, 1e-12);
}

TEST(Triangulate, AConcaveQuadIsCutAtItsNotch) {
  for (std::int32_t shift = 0; shift < 4; ++shift) {
    PolygonSoup soup{{{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}}, {}, {0}};  // the notch is vertex 3
    for (std::int32_t k = 0; k < 4; ++k) soup.loops.push_back((k + shift) % 4);
    EXPECT_NEAR(total_area(soup, triangles_of(soup)), 1.5, 1e-12);
  }
}

TEST(Triangulate, ConcavePolygonsInSpaceAreFilledWithoutOverlap) {
  PolygonSoup star;  // ten corners, radii 1 and 0.3, in a slanted plane
  const Vec3 x = Vec3(1, 2, 3).normalized(), y = x.unitOrthogonal();
  for (std::int32_t i = 0; i < 10; ++i) {
    const double r = i % 2 == 0 ? 1.0 : 0.3, angle = i * std::numbers::pi / 5;
    star.vertices.push_back(Vec3(7, 8, 9) + r * (std::cos(angle) * x + std::sin(angle) * y));
    star.loops.push_back(i);
  }
  star.loop_start = {0};
  const Triangulation t = triangles_of(star);
  EXPECT_EQ(t.triangles.size(), 8);
  EXPECT_NEAR(total_area(star, t), 10 * 0.5 * 0.3 * std::sin(std::numbers::pi / 5), 1e-12);
  for (const auto& [a, b, c] : t.triangles)
    EXPECT_GT((star.vertices[b] - star.vertices[a]).cross(star.vertices[c] - star.vertices[a]).dot(x.cross(y)), 0);
}

TEST(Triangulate, AFrameWithABridgeToItsHoleIsFilled) {
  // The outer square, in to the hole along a bridge, around it, and back along the bridge.
  const PolygonSoup soup{{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}},
                         {0, 1, 2, 3, 0, 4, 5, 6, 7, 4},
                         {0}};
  const Triangulation t = triangles_of(soup);
  EXPECT_EQ(t.triangles.size(), 8);
  EXPECT_NEAR(total_area(soup, t), 8, 1e-12);
}

TEST(Triangulate, BadPolygonsGetSomeTriangles) {
  const double nan = std::nan("");
  const PolygonSoup soup{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {nan, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                         {0, 1, 2, 3, /**/ 0, 1, 4, 5, 6, /**/ 0, 5, 1, 6, /**/ 0, 1, /**/ 2, 2, 2, 2},
                         {0, 4, 9, 13, 15}};
  EXPECT_EQ(triangles_of(soup).source_polygon, (std::vector<std::int32_t>{0, 0, 1, 1, 1, 2, 2, 4, 4}));
}

/// As triangles_of(), but gives up after so many polls: a measure of the work that is the same on every machine.
Triangulation with_few_polls(const PolygonSoup& soup) {
  Counting counting(1001);
  return triangulate(soup, counting.job);
}

PolygonSoup outline(std::vector<Vec3> places) {
  PolygonSoup soup{std::move(places), {}, {0}};
  soup.loops.resize(soup.vertices.size());
  std::iota(soup.loops.begin(), soup.loops.end(), 0);
  return soup;
}

TEST(Triangulate, ASpiralOfManyCornersTakesLittleWork) {
  constexpr int kHalf = 25000;
  std::vector<Vec3> places;  // a band of width 3 with 30 turns
  for (int i = 0; i < 2 * kHalf; ++i) {
    const double angle = 60 * std::numbers::pi * (i < kHalf ? i : 2 * kHalf - 1 - i) / kHalf;
    places.push_back((1 + angle + (i < kHalf ? 0 : 3)) * Vec3(std::cos(angle), std::sin(angle), 0));
  }
  const PolygonSoup spiral = outline(std::move(places));
  double area = 0;
  for (std::size_t i = 0; i < spiral.vertices.size(); ++i)
    area += spiral.vertices[i].cross(spiral.vertices[(i + 1) % spiral.vertices.size()]).z() / 2;
  const Triangulation t = with_few_polls(spiral);
  EXPECT_EQ(t.triangles.size(), 2 * kHalf - 2);
  EXPECT_NEAR(total_area(spiral, t), std::abs(area), 1e-6 * std::abs(area));
}

TEST(Triangulate, APolygonThatCrossesItselfEverywhereTakesLittleWork) {
  std::mt19937 random(1);
  const auto place = [&] { return static_cast<double>(random()) / static_cast<double>(std::mt19937::max()); };
  std::vector<Vec3> places;
  for (int i = 0; i < 20000; ++i) {
    const double x = place(), y = place();
    places.emplace_back(x, y, 0);
  }
  EXPECT_EQ(with_few_polls(outline(std::move(places))).triangles.size(), 19998);
}

TEST(Triangulate, APolygonOfManyCornersTakesNoTime) {
  PolygonSoup comb;  // 20,000 teeth
  for (std::int32_t i = 0; i < 40000; ++i) comb.vertices.emplace_back(i, i % 2 == 0 ? 1 : 3, 0);
  comb.vertices.emplace_back(39999, 0, 0);
  comb.vertices.emplace_back(0, 0, 0);
  for (std::int32_t i = 40001; i >= 0; --i) comb.loops.push_back(i);
  comb.loop_start = {0};
  const Triangulation t = with_few_polls(comb);
  EXPECT_EQ(t.triangles.size(), 40000);
  EXPECT_NEAR(total_area(comb, t), 2 * 39999, 1e-6);
}

}  // namespace
}  // namespace isimp
