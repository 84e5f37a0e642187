#include "hierarchy/features.h"
#include "tests.h"

namespace isimp {
namespace {

RegionSum flat(double area, double cosine) {
  RegionSum sum;
  sum.x = area * std::sqrt(1 - cosine * cosine);
  sum.z = area * cosine;
  sum.weight = 2 * area;
  sum.faces = 1;
  return sum;
}

/// Whether a part stays one of its own as it joins a region of nine tenths of the area.
bool keeps(double area, double cosine, double cost) {
  constexpr double kLimit = 0.01, kMergeCost = 0.05;
  const MergeTree tree{.leaves = 2, .merged = {{0, 1}}, .cost = {kMergeCost}};
  const std::vector<RegionSum> leaves{flat(0.9, 1), flat(area, cosine)};
  return keeps_features(tree, leaves, kLimit, cost);
}

TEST(Features, AreSteepPartsThatCostMoreThanTheLimit) {
  EXPECT_FALSE(keeps(0.1, -0.2, 0.06));
  EXPECT_FALSE(keeps(0.1, 0.2, 0.06));
  EXPECT_TRUE(keeps(0.1, 0.4, 0.06)) << "it leans on the region";
  EXPECT_TRUE(keeps(0.01, 0.2, 0.06)) << "it is small";
  EXPECT_TRUE(keeps(0.1, 0.2, 0.04)) << "it joins no region";
}

}  // namespace
}  // namespace isimp
