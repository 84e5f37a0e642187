#include "hull.h"
#include "isimp/convex/convex_parts.h"
#include "isimp/mesh/meet.h"
#include "tests.h"

namespace isimp {
namespace {

struct Box {
  Vec3 low, high;
  [[nodiscard]] bool contains(const Vec3& p) const {
    return (p.array() > low.array()).all() && (p.array() < high.array()).all();
  }
};

/// The border of a union of boxes, as quads of the grid of all their planes.
PolygonSoup border(const std::vector<Box>& boxes) {
  std::array<std::vector<double>, 3> steps;
  for (int k = 0; k < 3; ++k) {
    std::set<double> places;
    for (const Box& box : boxes) places.insert({box.low[k], box.high[k]});
    steps[k].assign(places.begin(), places.end());
  }
  const auto full = [&](const std::array<int, 3>& cell) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      if (cell[k] < 0 || cell[k] + 1 >= std::ssize(steps[k])) return false;
      p[k] = (steps[k][cell[k]] + steps[k][cell[k] + 1]) / 2;
    }
    return std::ranges::any_of(boxes, [&](const Box& box) { return box.contains(p); });
  };
  PolygonSoup soup;
  std::map<std::array<int, 3>, std::int32_t> names;
  std::array<int, 3> cell{};
  for (cell[0] = -1; cell[0] < std::ssize(steps[0]); ++cell[0])
    for (cell[1] = -1; cell[1] < std::ssize(steps[1]); ++cell[1])
      for (cell[2] = -1; cell[2] < std::ssize(steps[2]); ++cell[2])
        for (int k = 0; k < 3; ++k) {
          std::array<int, 3> next = cell;
          ++next[k];
          const bool here = full(cell), there = full(next);
          if (here == there) continue;
          soup.loop_start.push_back(static_cast<std::int32_t>(soup.loops.size()));
          for (int i = 0; i < 4; ++i) {
            const int turn = here ? i : 3 - i;
            std::array<int, 3> corner = next;
            corner[(k + 1) % 3] += turn == 1 || turn == 2;
            corner[(k + 2) % 3] += turn >= 2;
            const auto [at, is_new] = names.try_emplace(corner, static_cast<std::int32_t>(soup.vertices.size()));
            if (is_new) soup.vertices.push_back({steps[0][corner[0]], steps[1][corner[1]], steps[2][corner[2]]});
            soup.loops.push_back(at->second);
          }
        }
  return soup;
}

PolygonSoup soup_of(const shapes::Arrays& arrays) {
  PolygonSoup soup{.vertices = arrays.vertices, .loops = {}, .loop_start = {}};
  for (const Triangle& t : arrays.triangles) {
    soup.loop_start.push_back(static_cast<std::int32_t>(soup.loops.size()));
    soup.loops.insert(soup.loops.end(), t.begin(), t.end());
  }
  return soup;
}

std::vector<ConvexPart> parts_of(const PolygonSoup& soup, const ConvexOptions& options = {},
                                 std::span<const Vec3> enclosed = {}) {
  return convex_parts(soup, {}, enclosed, options, job());
}

bool contains(const ConvexPart& part, const Vec3& p) {
  return std::ranges::all_of(part.triangles, [&](const Triangle& t) {
    return side_of({part.vertices[t[0]], part.vertices[t[1]], part.vertices[t[2]]}, p) <= 0;
  });
}

bool contain(const std::vector<ConvexPart>& parts, const Vec3& p) {
  return std::ranges::any_of(parts, [&](const ConvexPart& part) { return contains(part, p); });
}

double volume(const std::vector<ConvexPart>& parts) {
  double sum = 0;
  for (const ConvexPart& part : parts) sum += part.volume;
  return sum;
}

/// All that holds for every part.
void expect_convex(const std::vector<ConvexPart>& parts) {
  for (const ConvexPart& part : parts) {
    EXPECT_EQ(part.triangles.size(), 2 * part.vertices.size() - 4);
    EXPECT_GT(part.volume, 0);
    for (const Vec3& p : part.vertices) EXPECT_TRUE(contains(part, p));
  }
}

std::string refusal(const PolygonSoup& soup, const ConvexOptions& options = {}) {
  return message_of([&] { parts_of(soup, options); });
}

constexpr double kWall = 0.25;

/// A room of 5 by 4 by 2.5 with a door and a window: 11 boxes.
std::vector<Box> room() {
  const double w = 5, d = 4, h = 2.5, t = kWall;
  return {{{-t, -t, -t}, {w + t, d + t, 0}},
          {{-t, -t, h}, {w + t, d + t, h + t}},
          {{-t, -t, 0}, {0, d + t, h}},
          {{0, d, 0}, {w, d + t, h}},
          {{w, -t, 0}, {w + t, 1.25, h}},
          {{w, 2.75, 0}, {w + t, d + t, h}},
          {{w, 1.25, 0}, {w + t, 2.75, 1}},
          {{w, 1.25, 2}, {w + t, 2.75, h}},
          {{0, -t, 0}, {1, 0, h}},
          {{2, -t, 0}, {w, 0, h}},
          {{1, -t, 2}, {2, 0, h}}};
}

struct Known {
  std::vector<Box> boxes;
  std::size_t parts;
  std::vector<Vec3> free;
};

class ConvexBoxes : public testing::TestWithParam<Known> {};

TEST_P(ConvexBoxes, BecomeTheFewestPartsOfTheirVolume) {
  const auto& [boxes, count, free] = GetParam();
  const std::vector<ConvexPart> parts = parts_of(border(boxes));
  expect_convex(parts);
  EXPECT_EQ(parts.size(), count);
  double whole = 0;
  for (const Box& box : boxes) whole += (box.high - box.low).prod();
  EXPECT_NEAR(volume(parts), whole, 1e-9 * whole);
  for (const ConvexPart& part : parts) EXPECT_EQ(part.triangles.size(), 12);
  for (const Vec3& p : free) EXPECT_FALSE(contain(parts, p)) << p.transpose();
  for (const Box& box : boxes) EXPECT_TRUE(contain(parts, (box.low + box.high) / 2));
}

INSTANTIATE_TEST_SUITE_P(
    Known, ConvexBoxes,
    testing::Values(
        Known{{{{0, 0, 0}, {1, 2, 3}}}, 1, {}},                                                                 // a box
        Known{{{{0, 0, 0}, {2, 1, 1}}, {{0, 1, 0}, {1, 2, 1}}}, 2, {{1.5, 1.5, 0.5}}},                          // an L
        Known{{{{0, 0, 0}, {3, 1, 1}}, {{0, 1, 0}, {1, 2, 1}}, {{2, 1, 0}, {3, 2, 1}}}, 3, {{1.5, 1.5, 0.5}}},  // a U
        Known{{{{0, 0, 0}, {3, 1, 1}}, {{0, 2, 0}, {3, 3, 1}}, {{0, 1, 0}, {1, 2, 1}}, {{2, 1, 0}, {3, 2, 1}}},
              4,
              {{1.5, 1.5, 0.5}}},  // a frame
        Known{{{{0, 0, 0}, {4, 4, 1}},
               {{0, 0, 3}, {4, 4, 4}},
               {{0, 0, 1}, {1, 4, 3}},
               {{3, 0, 1}, {4, 4, 3}},
               {{1, 0, 1}, {3, 1, 3}},
               {{1, 3, 1}, {3, 4, 3}}},
              6,
              {{2, 2, 2}, {1.25, 1.25, 1.25}}},  // a box with a void
        Known{room(), 11, {{1.5, -0.125, 1}, {5.125, 2, 1.5}, {2.5, 2, 1}}}));

TEST(ConvexParts, OfACarriedFarAwayCubeAreACube) {
  const std::vector<ConvexPart> parts = parts_of(soup_of(shapes::moved(shapes::cube(3), {4600000, 5400000, 300})));
  expect_convex(parts);
  ASSERT_EQ(parts.size(), 1);
  EXPECT_EQ(parts[0].vertices.size(), 8);
  EXPECT_NEAR(parts[0].volume, 1, 1e-6);
}

TEST(ConvexParts, DoNotDependOnTheUnit) {
  const PolygonSoup metres = border(room());
  PolygonSoup others = metres;
  for (Vec3& p : others.vertices) p *= 1024;
  const auto a = parts_of(metres), b = parts_of(others);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].triangles, b[i].triangles);
    for (std::size_t v = 0; v < a[i].vertices.size(); ++v) EXPECT_EQ(a[i].vertices[v] * 1024, b[i].vertices[v]);
  }
}

TEST(ConvexParts, OfABallAreTheBall) {
  const auto ball = parts_of(soup_of(shapes::sphere(2)), {.tolerance = 0.05});
  expect_convex(ball);
  ASSERT_EQ(ball.size(), 1);
  const auto few = parts_of(soup_of(shapes::sphere(2)), {.tolerance = 0.05, .most_vertices = 12});
  EXPECT_LE(few[0].vertices.size(), 12);
}

TEST(ConvexParts, OfATorusLeaveItsHoleFree) {
  const PolygonSoup torus = soup_of(shapes::torus(checks::size(12, 8), checks::size(8, 6)));
  const auto fine = parts_of(torus, {.tolerance = 0.1});
  expect_convex(fine);
  EXPECT_FALSE(contain(fine, Vec3::Zero()));
  EXPECT_EQ(parts_of(torus, {.parts = 3}).size(), 3);
  EXPECT_EQ(parts_of(torus, {.parts = 1}).size(), 1);
}

TEST(ConvexParts, EncloseEveryPoint) {
  const shapes::Arrays torus = shapes::noisy(shapes::torus(checks::size(12, 8), checks::size(8, 6)), 0.01, 1);
  for (const std::int32_t most : {12, 64}) {
    const auto parts = parts_of(soup_of(torus), {.tolerance = 0.1, .most_vertices = most}, torus.vertices);
    expect_convex(parts);
    for (const Vec3& p : torus.vertices) EXPECT_TRUE(contain(parts, p));
    for (const ConvexPart& part : parts) EXPECT_LE(std::ssize(part.vertices), most);
  }
}

TEST(ConvexParts, OfSolidsThatOverlapAreOnlyOnce) {
  const shapes::Arrays cube = shapes::cube();
  shapes::Arrays small = cube;
  for (Vec3& p : small.vertices) p = Vec3(0.25, 0.25, 0.25) + p / 2;
  EXPECT_NEAR(volume(parts_of(soup_of(shapes::both(cube, small, Vec3::Zero())))), 1, 1e-9);  // one in the other
  const auto crossing = parts_of(soup_of(shapes::both(cube, cube, {0.5, 0, 0})));
  ASSERT_EQ(crossing.size(), 1);
  EXPECT_NEAR(crossing[0].volume, 1.5, 1e-9);
  EXPECT_EQ(parts_of(soup_of(shapes::both(cube, cube, {2, 0, 0}))).size(), 2);
}

TEST(ConvexParts, OfASmallHoleAreThoseWithoutIt) {
  shapes::Arrays cube = shapes::cube(4);
  cube.triangles.pop_back();
  const auto parts = parts_of(soup_of(cube));
  ASSERT_EQ(parts.size(), 1);
  EXPECT_NEAR(parts[0].volume, 1, 1e-9);
}

TEST(ConvexParts, OfAWallAreOneForEachRegion) {
  const shapes::Arrays plane = shapes::plane(2);
  std::vector<std::int32_t> halves;
  for (const auto& [a, b, c] : plane.triangles)
    halves.push_back((plane.vertices[a] + plane.vertices[b] + plane.vertices[c]).x() > 1.5 ? 1 : 0);
  const std::vector<std::int32_t> one(halves.size(), 0);
  EXPECT_EQ(convex_parts(soup_of(plane), one, {}, {.thickness = kWall}, job()).size(), 1);
  EXPECT_EQ(convex_parts(soup_of(plane), halves, {}, {.thickness = kWall}, job()).size(), 2);
}

TEST(ConvexParts, RefuseWhatIsNoSolid) {
  EXPECT_NE(refusal({}).find("no polygons"), std::string::npos);
  shapes::Arrays plate = shapes::plane(4);
  EXPECT_NE(refusal(soup_of(plate)).find("is open"), std::string::npos);
  for (Triangle t : shapes::plane(4).triangles) plate.triangles.push_back({t[0], t[2], t[1]});
  EXPECT_NE(refusal(soup_of(plate)).find("encloses no volume around (0.5"), std::string::npos);
  shapes::Arrays reversed = shapes::cube(2);
  for (Triangle& t : reversed.triangles) std::swap(t[0], t[1]);
  EXPECT_NE(refusal(soup_of(reversed)).find("faces inwards around (0.5"), std::string::npos);
  shapes::Arrays half = shapes::sphere(checks::size(3, 2));
  std::erase_if(half.triangles, [&](const Triangle& t) {
    return half.vertices[t[0]].z() + half.vertices[t[1]].z() + half.vertices[t[2]].z() > 0;
  });
  EXPECT_NE(refusal(soup_of(half)).find("is open"), std::string::npos);
  PolygonSoup wrong = soup_of(shapes::cube());
  wrong.loops[4] = 8;
  EXPECT_NE(refusal(wrong).find("uses vertex 8, but there are 8 vertices"), std::string::npos);
  const PolygonSoup cube = soup_of(shapes::cube());
  PolygonSoup late = soup_of(shapes::cube(2));
  late.loop_start[0] = 3;
  EXPECT_NE(refusal(late).find("must rise from 0"), std::string::npos);
  late.loop_start.clear();
  EXPECT_NE(refusal(late).find("is empty"), std::string::npos);
  EXPECT_NE(refusal(cube, {.tolerance = -1}).find("tolerance"), std::string::npos);
  EXPECT_NE(refusal(cube, {.most_vertices = 7}).find("at least 8"), std::string::npos);
  EXPECT_NE(refusal(cube, {.parts = -1}).find("parts"), std::string::npos);
}

TEST(ConvexParts, StopWhenCancelled) {
  Job job;
  job.at_poll = [&] { job.cancel(); };
  EXPECT_THROW(convex_parts(border(room()), {}, {}, {}, job), Cancelled);
}

TEST(Hull, OfPointsOnAGridIsACube) {
  std::vector<Vec3> points;
  points.reserve(125);
  for (int i = 0; i < 125; ++i) points.emplace_back(i % 5, i / 5 % 5, i / 25);
  const ConvexPart hull = convex::simple_hull_of(points, 1e-9, 64);
  EXPECT_EQ(hull.vertices.size(), 8);
  EXPECT_EQ(hull.triangles.size(), 12);
  EXPECT_NEAR(hull.volume, 64, 1e-12);
  EXPECT_NEAR(convex::hull_of(points, 0, 1).volume, 64, 1e-12);  // by integers
}

TEST(Hull, OfPointsInAPlaneIsNone) {
  std::vector<Vec3> points;
  points.reserve(25);
  for (int i = 0; i < 25; ++i) points.emplace_back(i % 5, i / 5, i % 5 + i / 5);
  EXPECT_TRUE(convex::hull_of(points, 0).vertices.empty());
}

}  // namespace
}  // namespace isimp
