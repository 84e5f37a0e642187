#include "hierarchy/choose_cut.h"
#include "hierarchy/detail_tree.h"
#include "isimp/partition/noise.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::Arrays;

/// Costs of a shape without planes of its own: C_P falls like 1 / P^2.
std::vector<double> without_scale() {
  std::vector<double> costs;
  for (int regions = 2; regions < 400; ++regions) costs.push_back(1.0 / regions / regions);
  return costs;
}

TEST(CutRule, WithoutAGapStaysAtTheTolerance) {
  const Cut cut = choose_cut(without_scale(), 1, 1e-12, 0.005, 0.005, 0, true);
  EXPECT_FALSE(cut.snapped);
  EXPECT_DOUBLE_EQ(cut.cost, 16 * 0.005 * 0.005);
}

TEST(CutRule, NumberOfRegionsIsAMeanOverNearTolerances) {
  std::vector<double> costs = without_scale();
  const auto regions = [&](double tolerance) {
    const Cut cut = choose_cut(costs, 1, 1e-12, tolerance, 0.001, 0, false);
    return 1 + std::count_if(costs.begin(), costs.end(), [&](double c) { return c > cut.cost; });
  };
  EXPECT_EQ(regions(0.005), 49);  // like the number at t itself: 16 t^2 = 1 / 50^2 is the cost of merging 50 regions
  // Ten costs just below the limit, such as those of ten bumps: at t alone, their regions would appear all at once.
  for (std::size_t k = 49; k < 59; ++k) costs[k] = (0.99 - 1e-4 * static_cast<double>(k)) / 50 / 50;
  std::int64_t most = 0;
  for (double t = 0.006; t > 0.004; t /= 1.01) most = std::max(most, regions(t / 1.01) - regions(t));
  EXPECT_LE(most, 3);
}

TEST(CutRule, MovesIntoASignificantGap) {
  std::vector<double> costs = without_scale();  // 49 of them at or above .0004
  for (std::size_t k = 49; k < costs.size(); ++k) costs[k] /= 50;
  const Cut cut = choose_cut(costs, 1, 1e-12, 0.0025, 0.001, 0, true);  // the limit is 1e-4
  EXPECT_TRUE(cut.snapped);
  EXPECT_LT(cut.cost, costs[48]);
  EXPECT_GT(cut.cost, costs[49]);
  EXPECT_FALSE(choose_cut(costs, 1, 1e-12, 0.0025, 0.001, 0, false).snapped);
  EXPECT_FALSE(choose_cut(costs, 1, 1e-12, 0.02, 0.001, 0, true).snapped);  // the gap is finer than requested
}

TEST(CutRule, AGapCountsBeyondTheWindow) {
  // A box whose sides bulge: the six sides merge at t = .1, and none of their parts above .0178. The window ends at .02.
  std::vector<double> costs(5, 16 * 0.1 * 0.1);
  for (int regions = 6; regions < 400; ++regions) costs.push_back(16 * std::pow(0.0178 * 6 / regions, 2));
  const Cut cut = choose_cut(costs, 1, 1e-12, 0.005, 0.001, 0, true);
  EXPECT_TRUE(cut.snapped);
  EXPECT_LT(cut.cost, costs[4]);
  EXPECT_GT(cut.cost, costs[5]);
}

TEST(CutRule, NoiseCountsAsToleranceButDoesNotAddToIt) {
  EXPECT_DOUBLE_EQ(merge_limit(0.5, 0.1), 16 * 0.25);
  EXPECT_DOUBLE_EQ(merge_limit(0.5, 1.0), 16 * 2.4 * 2.4);
}

TEST(CutRule, TakesTheWidestGapThatFits) {
  std::vector<double> costs(10, 16 * 0.06 * 0.06);
  costs.insert(costs.end(), 20, 16 * 0.009 * 0.009);
  for (int regions = 31; regions < 400; ++regions) costs.push_back(16 * std::pow(0.002 * 31 / regions, 2));
  const auto taken = [&](double most) {
    return choose_cut(costs, 1, 1e-12, 0.005, 0.001, 0, true, [&](double cost) { return cost < most; });
  };
  const Cut wide = taken(1), narrow = taken(costs[10]), none = taken(0);
  EXPECT_TRUE(wide.snapped);
  EXPECT_GT(wide.cost, costs[10]);
  EXPECT_TRUE(narrow.snapped);
  EXPECT_LT(narrow.cost, costs[29]);
  EXPECT_GT(narrow.cost, costs[30]);
  EXPECT_FALSE(none.snapped);
}

struct Counted {
  std::int32_t regions;
  bool snapped;
};

Counted count_at(const Arrays& shape, double detail) {
  const Mesh mesh = shapes::mesh(shape);
  const DetailTree tree(mesh, {}, job());
  const Cut cut = tree.choose(detail * tree.size(), true);
  const Regions regions = tree.regions(mesh, cut, Threads(1), job());
  EXPECT_LE(regions.count(), tree.count(cut));
  const std::set<std::int32_t> used(regions.label.begin(), regions.label.end() - 1);
  EXPECT_EQ(used.size(), regions.sum.size());
  return {regions.count(), cut.snapped};
}

TEST(Detail, FindsTheSidesOfACubeOfAnyFaces) {
  for (const Arrays& shape : {shapes::cube(1), shapes::cube(20), shapes::shuffled(shapes::cube(13), 8),
                              shapes::noisy(shapes::cube(20), 0.003, 1), shapes::noisy(shapes::cube(20), 0.01, 2)})
    for (const double detail : {0.02, 0.005, 0.00125}) EXPECT_EQ(count_at(shape, detail).regions, 6);
}

TEST(Detail, FindsOnePlaneAndTwoCubes) {
  EXPECT_EQ(count_at(shapes::plane(20), 0.005).regions, 1);
  EXPECT_EQ(count_at(shapes::noisy(shapes::plane(20), 0.01, 2), 0.005).regions, 1);
  EXPECT_EQ(count_at(shapes::both(shapes::cube(8), shapes::cube(8), Vec3(3, 0, 0)), 0.005).regions, 12);
}

TEST(Detail, FollowsTheToleranceOnASphereAndNotTheFaces) {
  const Counted coarse = count_at(shapes::sphere(4), 0.01), fine = count_at(shapes::sphere(5), 0.01);
  EXPECT_FALSE(fine.snapped);
  EXPECT_NEAR(static_cast<double>(coarse.regions) / fine.regions, 1.0, 0.08);
  EXPECT_NEAR(static_cast<double>(count_at(shapes::sphere(5), 0.005).regions) / fine.regions, 2.0, 0.2);
}

TEST(Detail, LeavesAClosedPartFourRegions) {
  EXPECT_EQ(count_at(shapes::sphere(2), 0.4).regions, 4);
  // The small one is flat at this tolerance, but still a solid.
  EXPECT_EQ(
      count_at(shapes::both(shapes::plane(9), shapes::noisy(shapes::sphere(1), 0, 1), Vec3(0, 0, 9)), 0.4).regions, 5);
}

TEST(Detail, LeavesSpecksOut) {
  const Mesh mesh = shapes::mesh(shapes::both(shapes::cube(6), shapes::scaled(shapes::cube(1), 0.01), Vec3(3, 0, 0)));
  const DetailTree tree(mesh, {.noise = 0}, job());
  const Regions regions = tree.regions(mesh, tree.choose(0.01, true), Threads(1), job());
  EXPECT_EQ(regions.count(), 6);
  EXPECT_EQ(std::count(regions.label.begin(), regions.label.end(), kNone), 12 + 1);
}

TEST(Detail, LeavesNothingToMergeBelowTheCut) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(120, 60), 0.02, 4));
  const DetailTree tree(mesh, {.finest = 0.001, .noise = 0}, job());
  for (const double tolerance : {0.005, 0.01, 0.02}) {
    const Cut cut = tree.choose(tolerance, false);
    const Regions regions = tree.regions(mesh, cut, Threads(1), job());
    EXPECT_LT(regions.count(), tree.count(cut));  // borders that moved made more of them alike
    const ClusterGraph all = region_clusters(mesh.graph(), regions, job());
    EXPECT_EQ(merge_all(all, {.cost = cut.cost / mesh.graph().area, .need = {}}, job()).merges(), 0U) << tolerance;
  }
}

TEST(Detail, IsTheSameOnEveryRun) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(300, 150), 0.002, 4));  // enough faces for blocks
  const auto labels = [&](std::int32_t threads) {
    const DetailTree tree(mesh, {.finest = 0.001, .noise = 0.001}, job());
    return tree.regions(mesh, tree.choose(0.003, true), Threads(threads), job()).label;
  };
  EXPECT_EQ(labels(1), labels(1));
  EXPECT_EQ(labels(1), labels(3));
}

}  // namespace
}  // namespace isimp
