// Cohen-Steiner, Alliez, Desbrun: Variational Shape Approximation, 2004: the error that the merging raises least.

#include "hierarchy/dendrogram.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <unordered_set>
#include <utility>

#include "isimp/core/check.h"

namespace isimp {
namespace {

constexpr double kFlatAngle = 1e-5;  // rounding: radians; normals that differ by less are taken as equal

class Merging {
 public:
  Merging(ClusterGraph graph, const MergeLimits& limits)
      : limits_(limits), sum_(std::move(graph.sum)), component_(std::move(graph.component)) {
    const std::size_t n = sum_.size();
    tree_.leaves = static_cast<std::int32_t>(n);
    sum_.reserve(2 * n);
    links_.resize(n);
    into_.resize(n, kNone);
    mark_.resize(n, kNone);
    best_.resize(n);
    for (std::size_t u = 0; u < n; ++u)
      links_[u].assign(graph.neighbour.begin() + graph.first[u], graph.neighbour.begin() + graph.first[u + 1]);
    if (!limits.need.empty()) {
      left_.assign(limits.need.size(), 0);
      for (std::size_t u = 0; u < n; ++u) ++left_[component_of(static_cast<std::int32_t>(u))];
    }
  }

  MergeTree run(Job& job) {
    for (std::int32_t u = 0; u < tree_.leaves; ++u) {
      if ((u & kPollEvery) == 0) job.poll();
      tidy(u);
      find_best(u);
    }
    while (!queue_.empty()) {
      if ((tree_.merged.size() & kPollEvery) == 0) job.poll();
      const Offer offer = queue_.top();
      queue_.pop();
      const std::int32_t u = offer.from;
      if (into_[u] != kNone || best_[u].stamp != offer.stamp) continue;
      const double cost = std::max(0.0, merge_cost(sum_[u], sum_[offer.to]));
      if (cost > limits_.cost) break;
      if (!left_.empty() && left_[component_of(u)] <= limits_.need[component_of(u)]) continue;
      if (limits_.accept && !limits_.accept(u, offer.to)) {
        refused_.insert(pair_of(u, offer.to));
        tidy(u);
        find_best(u);
        continue;
      }
      merge(u, offer.to, cost);
    }
    return std::move(tree_);
  }

 private:
  struct Offer {
    double key;
    std::int32_t from, to, stamp;
    bool operator>(const Offer& o) const {
      return key != o.key ? key > o.key : from != o.from ? from > o.from : to > o.to;
    }
  };
  struct Best {
    double key = std::numeric_limits<double>::infinity();
    std::int32_t node = kNone;
    std::int32_t stamp = 0;
  };
  static constexpr std::size_t kPollEvery = 0x3ff;  // work

  [[nodiscard]] std::int32_t component_of(std::int32_t u) const { return component_.empty() ? 0 : component_[u]; }

  static std::uint64_t pair_of(std::int32_t u, std::int32_t v) {
    const auto [low, high] = std::minmax(u, v);
    return static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high);
  }

  /// The key that orders pairs: the cost, and a small term that puts small nodes first where all cost nothing.
  [[nodiscard]] double key(std::int32_t u, std::int32_t v) const {
    const RegionSum &a = sum_[u], &b = sum_[v];
    const double both = a.weight + b.weight;
    const double smaller = both > 0 ? a.weight * b.weight / both : 0.0;
    return std::max(0.0, merge_cost(a, b)) + kFlatAngle * kFlatAngle * smaller;
  }

  std::int32_t root(std::int32_t u) {
    while (into_[u] != kNone) {
      const std::int32_t up = into_[u];
      if (into_[up] == kNone) return up;
      u = into_[u] = into_[up];
    }
    return u;
  }

  /// Brings the links of a node up to date: each neighbour once.
  void tidy(std::int32_t u) {
    std::vector<std::int32_t>& links = links_[u];
    std::size_t kept = 0;
    for (const std::int32_t link : links) {
      const std::int32_t v = root(link);
      if (v == u || mark_[v] == u) continue;
      mark_[v] = u;
      links[kept++] = v;
    }
    links.resize(kept);
    for (const std::int32_t v : links) mark_[v] = kNone;
  }

  void offer(std::int32_t u, double key, std::int32_t to) {
    best_[u] = {key, to, best_[u].stamp + 1};
    queue_.push({key, u, to, best_[u].stamp});
  }

  /// \pre the links of u are tidy
  void find_best(std::int32_t u) {
    double least = std::numeric_limits<double>::infinity();
    std::int32_t to = kNone;
    for (const std::int32_t v : links_[u]) {
      if (!refused_.empty() && refused_.contains(pair_of(u, v))) continue;
      const double k = key(u, v);
      if (k < least || (k == least && v < to)) {
        least = k;
        to = v;
      }
    }
    if (to != kNone) {
      offer(u, least, to);
    } else {
      best_[u] = {least, kNone, best_[u].stamp + 1};
    }
  }

  void merge(std::int32_t u, std::int32_t v, double cost) {
    ISIMP_ASSERT(u != v && into_[u] == kNone && into_[v] == kNone && component_of(u) == component_of(v),
                 "two nodes of one component that have not merged yet merge");
    const auto w = static_cast<std::int32_t>(sum_.size());
    tree_.merged.push_back({u, v});
    tree_.cost.push_back(cost);
    sum_.push_back(sum_[u]);
    sum_.back().add(sum_[v]);
    if (!component_.empty()) component_.push_back(component_[u]);
    if (!left_.empty()) --left_[component_of(w)];
    into_[u] = into_[v] = w;
    into_.push_back(kNone);
    mark_.push_back(kNone);
    best_.emplace_back();
    std::vector<std::int32_t> links = std::move(links_[u]), fewer = std::move(links_[v]);
    if (links.size() < fewer.size()) links.swap(fewer);
    links.insert(links.end(), fewer.begin(), fewer.end());
    links_.push_back(std::move(links));
    tidy(w);
    find_best(w);
    for (const std::int32_t x : links_[w]) {
      if (best_[x].node == u || best_[x].node == v) {
        tidy(x);
        find_best(x);
      } else if (const double k = key(w, x); k < best_[x].key) {
        offer(x, k, w);
      }
    }
  }

  const MergeLimits& limits_;
  std::vector<RegionSum> sum_;
  std::vector<std::int32_t> component_, left_;
  std::vector<std::vector<std::int32_t>> links_;
  std::vector<std::int32_t> into_;  // the node that a node was merged into, path shortened; kNone while it exists
  std::vector<std::int32_t> mark_;
  std::vector<Best> best_;
  std::priority_queue<Offer, std::vector<Offer>, std::greater<>> queue_;
  std::unordered_set<std::uint64_t> refused_;  // pairs that limits.accept refused; only searched, never iterated
  MergeTree tree_;
};

}  // namespace

ClusterGraph face_clusters(const FaceGraph& graph, std::span<const FaceRecord> faces) {
  ClusterGraph result;
  const std::int32_t n = graph.size();
  result.sum.resize(static_cast<std::size_t>(n));
  result.first.reserve(static_cast<std::size_t>(n) + 1);
  result.neighbour.reserve(3 * static_cast<std::size_t>(n));
  result.first.push_back(0);
  for (std::int32_t i = 0; i < n; ++i) {
    result.sum[i].add(faces[i]);
    for (const std::int32_t j : graph.neighbours[i])
      if (j != n) result.neighbour.push_back(j);
    result.first.push_back(static_cast<std::int32_t>(result.neighbour.size()));
  }
  return result;
}

ClusterGraph region_clusters(const FaceGraph& graph, const Regions& regions, Job& job) {
  ClusterGraph result;
  result.sum = regions.sum;
  result.first.assign(regions.sum.size() + 1, 0);
  const std::int32_t n = graph.size();
  const auto for_each_border = [&](auto&& use) {
    for (std::int32_t i = 0; i < n; ++i) {
      if ((i & 0xffff) == 0) job.poll();
      const std::int32_t own = regions.label[i];
      if (own == kNone) continue;
      for (const std::int32_t j : graph.neighbours[i])
        if (regions.label[j] != own && regions.label[j] != kNone) use(own, regions.label[j]);
    }
  };
  for_each_border([&](std::int32_t own, std::int32_t) { ++result.first[own + 1]; });
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  result.neighbour.resize(static_cast<std::size_t>(result.first.back()));
  std::vector<std::int32_t> fill(result.first.begin(), result.first.end() - 1);
  for_each_border([&](std::int32_t own, std::int32_t other) { result.neighbour[fill[own]++] = other; });
  return result;
}

MergeTree merge_all(ClusterGraph graph, const MergeLimits& limits, Job& job) {
  Merging merging(std::move(graph), limits);  // the rest of the graph is freed while it runs
  return merging.run(job);
}

std::vector<std::int32_t> cut_after(const MergeTree& tree, std::size_t merges) {
  std::vector<std::int32_t> above(static_cast<std::size_t>(tree.leaves) + merges, kNone);
  for (std::size_t k = 0; k < merges; ++k)
    for (const std::int32_t node : tree.merged[k]) above[node] = tree.leaves + static_cast<std::int32_t>(k);
  for (std::size_t node = above.size(); node-- > 0;)  // a node has a lower number than the node it was merged into
    above[node] = above[node] == kNone ? static_cast<std::int32_t>(node) : above[above[node]];
  std::vector<std::int32_t> number(above.size(), kNone), result(static_cast<std::size_t>(tree.leaves));
  std::int32_t count = 0;
  for (std::int32_t leaf = 0; leaf < tree.leaves; ++leaf) {
    std::int32_t& id = number[above[leaf]];
    if (id == kNone) id = count++;
    result[leaf] = id;
  }
  return result;
}

}  // namespace isimp
