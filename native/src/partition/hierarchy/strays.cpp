#include "hierarchy/strays.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "isimp/core/check.h"
#include "isimp/core/forest.h"
#include "isimp/core/types.h"

namespace isimp {
namespace {

struct Stray {
  RegionSum sum;
  std::vector<std::int32_t> patches;
};

class Joining {
 public:
  Joining(const MergeGraph& touching, std::span<const RegionSum> sum, std::int32_t clusters,
          std::vector<std::int32_t>& cluster)
      : touching_(touching), cluster_(cluster), pieces_(sum.size()), total_(static_cast<std::size_t>(clusters)) {
    std::int32_t count = touching.size();
    for (std::int32_t u = 0; u < touching.size(); ++u)
      for (const std::int32_t v : touching.around(u))
        if (v < u && cluster[v] == cluster[u] && pieces_.join(u, v)) --count;
    if (count > clusters) find_strays(sum);
  }

  std::int32_t run() {
    const auto count = static_cast<std::int32_t>(strays_.size());
    for (std::size_t before = strays_.size() + 1; !strays_.empty() && strays_.size() < before;) {
      before = strays_.size();  // a stray among strays alone waits until one of them has joined
      std::erase_if(strays_, [&](const Stray& stray) { return join(stray); });
    }
    ISIMP_ASSERT(strays_.empty(), "every component has a connected cluster");
    return count;
  }

 private:
  void find_strays(std::span<const RegionSum> sum) {
    std::vector<RegionSum> piece(sum.size());  // by its root
    std::vector<std::int32_t> largest(total_.size(), kNone), stray(sum.size(), kNone);
    for (std::int32_t u = 0; u < touching_.size(); ++u) piece[pieces_.root(u)].add(sum[u]);
    for (std::int32_t u = 0; u < touching_.size(); ++u) {
      std::int32_t& kept = largest[cluster_[u]];
      if (pieces_.root(u) == u && (kept == kNone || piece[u].weight > piece[kept].weight)) kept = u;
    }
    settled_.assign(sum.size(), 1);
    for (std::size_t c = 0; c < total_.size(); ++c)
      if (largest[c] != kNone) total_[c] = piece[largest[c]];
    for (std::int32_t u = 0; u < touching_.size(); ++u) {
      const std::int32_t root = pieces_.root(u);
      if (root == largest[cluster_[u]]) continue;
      if (root == u) {
        stray[u] = static_cast<std::int32_t>(strays_.size());
        strays_.push_back({piece[u], {}});
      }
      strays_[stray[root]].patches.push_back(u);
      settled_[u] = 0;
    }
  }

  bool join(const Stray& stray) {
    double least = std::numeric_limits<double>::infinity();
    std::int32_t to = kNone;
    for (const std::int32_t u : stray.patches)
      for (const std::int32_t v : touching_.around(u)) {
        if (settled_[v] == 0) continue;
        const std::pair<double, std::int32_t> offer(merge_cost(total_[cluster_[v]], stray.sum), cluster_[v]);
        if (to == kNone || offer < std::pair(least, to)) std::tie(least, to) = offer;
      }
    if (to == kNone) return false;
    total_[to].add(stray.sum);
    for (const std::int32_t u : stray.patches) {
      cluster_[u] = to;
      settled_[u] = 1;
    }
    return true;
  }

  const MergeGraph& touching_;
  std::vector<std::int32_t>& cluster_;
  detail::Forest pieces_;              // patches that hang together in a cluster
  std::vector<RegionSum> total_;       // sum of each cluster without its strays
  std::vector<std::uint8_t> settled_;  // by patch
  std::vector<Stray> strays_;
};

}  // namespace

std::int32_t join_strays(const MergeGraph& touching, std::span<const RegionSum> sum, std::int32_t clusters,
                         std::vector<std::int32_t>& cluster) {
  return Joining(touching, sum, clusters, cluster).run();
}

}  // namespace isimp
