// The openings that count as errors of scanning.
#include "isimp/simplify/openings.h"
#include "tests.h"

namespace isimp {
namespace {

double length(const shapes::Arrays& a, std::int32_t regions) { return opening_length(shapes::mesh(a), regions, job()); }

TEST(Openings, AreMeasuredByTheRegions) {
  const shapes::Arrays scan = shapes::noisy(shapes::torus(120, 60), 0.001, 1);
  const double area = shapes::mesh(scan).graph().area, edge = std::sqrt(area / 14400 * 4 / std::sqrt(3.0));
  for (const std::int32_t regions : {100, 300, 1200}) {
    const double wanted = 0.5 * std::sqrt(area / regions);
    EXPECT_LE(length(scan, regions), wanted * (1 + 1e-12));
    EXPECT_GT(length(scan, regions), wanted / std::sqrt(2.0));
  }
  EXPECT_NEAR(length(scan, 1200), length(scan, 300) / 2, 1e-12);
  EXPECT_NEAR(length(scan, 1), 16 * edge, 1e-9) << "however few regions";
  int different = 0;
  for (std::int32_t regions = 300; regions < 600; regions += 10)
    different += length(scan, regions + 10) != length(scan, regions) ? 1 : 0;
  EXPECT_EQ(different, 1) << "so that a slider closes anew but seldom";
}

TEST(Openings, HolesOfOneVertexAreFilledAsLongAsRegionsAreLarger) {
  const shapes::Arrays scan = shapes::noisy(shapes::torus(120, 60), 0.001, 1);
  const Mesh mesh = shapes::mesh(scan);
  const double edge = std::sqrt(mesh.graph().area / 14400 * 4 / std::sqrt(3.0));
  for (const std::int32_t regions : {1, 100, 300, 1200}) {
    const OpeningLengths lengths = opening_lengths(mesh, regions, job());
    EXPECT_EQ(lengths.handles, length(scan, regions));
    EXPECT_GE(lengths.holes, lengths.handles);
    EXPECT_LE(lengths.holes, std::max(lengths.handles, std::sqrt(mesh.graph().area / regions)));
  }
  EXPECT_GT(opening_lengths(mesh, 100, job()).holes, 5 * edge);
  EXPECT_GT(opening_lengths(mesh, 100, job()).holes, 1.5 * length(scan, 100));
  EXPECT_EQ(opening_lengths(shapes::mesh(shapes::torus(120, 60)), 100, job()).holes, 0) << "drawn";
}

TEST(Openings, LengthsOfANumberThatIsNotKnownHoldUpToABound) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(120, 60), 0.001, 1));
  const GuessedLengths guessed = guess_opening_lengths(mesh, {.detail = 1.0}, job());
  ASSERT_GE(guessed.most, 2);
  EXPECT_TRUE(guessed.likely);
  for (const std::int32_t regions : {1, guessed.most})
    EXPECT_EQ(opening_lengths(mesh, regions, job()), guessed.lengths);
  EXPECT_NE(opening_lengths(mesh, guessed.most + 1, job()), guessed.lengths);
  EXPECT_FALSE(guess_opening_lengths(mesh, {.detail = 0.001}, job()).likely) << "many regions";
  EXPECT_FALSE(guess_opening_lengths(mesh, {.proxies = 2}, job()).likely) << "known";
  const GuessedLengths drawn = guess_opening_lengths(shapes::mesh(shapes::torus(120, 60)), {}, job());
  EXPECT_TRUE(drawn.likely) << "whatever is found, nothing is closed";
  EXPECT_EQ(drawn.lengths, OpeningLengths{});
}

TEST(Openings, OfDrawnModelsStay) {
  EXPECT_EQ(length(shapes::torus(120, 60), 300), 0);
  EXPECT_EQ(length(shapes::plane(40), 300), 0);
}

TEST(Openings, ThatAreNotThereNeedNoLength) {
  EXPECT_EQ(length(shapes::noisy(shapes::sphere(4), 0.005, 1), 30), 0);
  EXPECT_FALSE(has_openings(shapes::mesh(shapes::sphere(2))));
  EXPECT_TRUE(has_openings(shapes::mesh(shapes::plane(3))));
  EXPECT_TRUE(has_openings(shapes::mesh(shapes::torus(12, 6))));
}

TEST(Openings, AreMeasuredWithoutTheSmallestComponents) {
  const shapes::Arrays specks = shapes::both(shapes::cube(1), shapes::plane(1), {5, 0, 0});
  const shapes::Arrays scan = shapes::scaled(shapes::cube(4), 2);
  const Mesh mesh = shapes::mesh(shapes::both(scan, specks, {0, 0, 5}));
  const std::int32_t large = 12 * 16, all = large + 12 + 2;
  ASSERT_EQ(mesh.face_count(), all);
  for (const auto& [count, marked] : {std::pair(1, 2), std::pair(2, 14), std::pair(3, 14)}) {
    const std::vector<std::uint8_t> is_small = smallest_components(mesh, count, job());
    ASSERT_EQ(is_small.size(), static_cast<std::size_t>(all)) << count;
    EXPECT_EQ(std::count(is_small.begin(), is_small.end(), 1), marked) << count;
    EXPECT_EQ(is_small.back(), 1) << count;
  }
  EXPECT_TRUE(smallest_components(mesh, 0, job()).empty());
}

TEST(Openings, NeedARegion) { EXPECT_THROW(length(shapes::plane(3), 0), InvalidInput); }

}  // namespace
}  // namespace isimp
