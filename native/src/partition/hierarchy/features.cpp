#include "hierarchy/features.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace isimp {
namespace {

// tuned houses
constexpr double kSteep = 0.3;    // cosine of the angle to the surface that a part stands on
constexpr double kFeature = 2.0;  // least cost of such a part, in limits

std::vector<std::int32_t> cut_at(const MergeTree& tree, double cost) {
  const auto above = std::find_if(tree.cost.begin(), tree.cost.end(), [&](double c) { return c > cost; });
  return cut_after(tree, static_cast<std::size_t>(above - tree.cost.begin()));
}

}  // namespace

bool keeps_features(const MergeTree& tree, std::span<const RegionSum> leaves, double limit, double cost) {
  const std::vector<std::int32_t> fine = cut_at(tree, limit), coarse = cut_at(tree, cost);
  std::vector<RegionSum> sum(fine.size());
  std::vector<std::int32_t> into(fine.size(), kNone), largest(fine.size(), kNone);
  for (std::size_t p = 0; p < fine.size(); ++p) {
    sum[fine[p]].add(leaves[p]);
    into[fine[p]] = coarse[p];
  }
  const std::size_t count = std::find(into.begin(), into.end(), kNone) - into.begin();
  for (std::size_t f = 0; f < count; ++f) {
    std::int32_t& most = largest[into[f]];
    if (most == kNone || sum[f].weight > sum[most].weight) most = static_cast<std::int32_t>(f);
  }
  for (std::size_t f = 0; f < count; ++f) {
    const double cosine = sum[largest[into[f]]].normal().dot(sum[f].normal());
    if (cosine < kSteep && sum[f].weight * (1 - cosine) > kFeature * limit) return false;
  }
  return true;
}

}  // namespace isimp
