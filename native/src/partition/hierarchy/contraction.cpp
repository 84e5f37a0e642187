#include "hierarchy/contraction.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

namespace isimp {
namespace {

constexpr float kGate = 0.7F;
constexpr float kTie = 1e-6F;  // of the lengths
constexpr std::int32_t kAlone = -1;
constexpr std::int32_t kWorthAThread = 1 << 12;  // nodes

/// The cheapest partner of each node, and its price.
struct Best {
  std::vector<std::int32_t> partner;
  std::vector<float> price;
};

/// Symmetric tie-break: cluster size, and a hash of the pair. In planar areas, where every price is zero, small clusters
/// merge first and reciprocal pairs form. It is above the rounding of prices, about 1e-7 of the lengths in float32, so
/// that rounding of the coordinates, as far from zero, does not decide among equals. Tuned: of 3e-7, 1e-6 and 3e-6 this
/// one leaves the least error, and the most labels equal between a mesh at zero and at map coordinates.
float tie_break(std::int32_t u, std::int32_t v, float lengths) {
  const std::uint32_t name = (static_cast<std::uint32_t>(u) ^ static_cast<std::uint32_t>(v)) * 0x9e3779b9U;
  return kTie * lengths * (1.0F + static_cast<float>(name >> 16) * 0x1p-16F);
}

/// \param takes_part  by part: whether its nodes merge
Best find_partners(const MergeGraph& graph, const std::vector<std::uint8_t>& takes_part, const Threads& threads,
                   Job& job) {
  const std::int32_t n = graph.size();
  Best best{std::vector<std::int32_t>(n, kAlone), std::vector<float>(n, std::numeric_limits<float>::infinity())};
  threads.run(n, threads.pieces(n, kWorthAThread), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t u = begin; u < end; ++u) {
      if ((u & 0x3fff) == 0) job.poll();
      if (takes_part[graph.part_of(u)] == 0) continue;
      const NodeSum a = graph.sum[u];
      float least = std::numeric_limits<float>::infinity();
      std::int32_t partner = kAlone;
      for (const std::int32_t v : graph.around(u)) {
        const NodeSum b = graph.sum[v];
        const float x = a.x + b.x, y = a.y + b.y, z = a.z + b.z;
        const float lengths = a.length + b.length;
        const float price = lengths - std::sqrt(x * x + y * y + z * z) + tie_break(u, v, lengths);
        partner = price < least ? v : partner;
        least = price < least ? price : least;
      }
      best.partner[u] = partner;
      best.price[u] = least;
    }
  });
  return best;
}

/// The price up to which pairs merge: what would stand at kGate of the way if all prices were sorted. Only those that
/// agree with it in their first bits are.
float gate(const Best& best) {
  constexpr int kShift = 20;  // leaves exponent and three digits; prices are not below 0, so their bits rise with them
  const auto bucket = [](float price) { return std::bit_cast<std::uint32_t>(std::max(0.0F, price)) >> kShift; };
  const std::uint32_t none = bucket(std::numeric_limits<float>::infinity());  // price of what does not merge
  std::vector<std::size_t> count(none + 1, 0);
  for (const float price : best.price) ++count[bucket(price)];
  const std::size_t priced = best.price.size() - count[none];
  if (priced == 0) return 0.0F;
  auto rank = static_cast<std::size_t>(kGate * static_cast<float>(priced - 1));
  std::uint32_t of_rank = 0;
  while (rank >= count[of_rank]) rank -= count[of_rank++];
  std::vector<float> alike(count[of_rank] + 1);  // one spare, written to before it is known to be wanted
  std::size_t out = 0;
  for (const float price : best.price) {
    alike[out] = price;
    out += bucket(price) == of_rank ? 1 : 0;
  }
  const auto at = alike.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(alike.begin(), at, alike.end() - 1);
  return *at;
}

/// Of each part, whether it has more than so many nodes.
std::vector<std::uint8_t> parts_above(const MergeGraph& graph, std::int32_t least) {
  if (graph.part.empty()) return {graph.size() > least};
  std::vector<std::int32_t> nodes(
      static_cast<std::size_t>(1 + *std::max_element(graph.part.begin(), graph.part.end())));
  for (const std::int32_t c : graph.part) ++nodes[c];
  std::vector<std::uint8_t> above(nodes.size());
  for (std::size_t c = 0; c < nodes.size(); ++c) above[c] = nodes[c] > least ? 1 : 0;
  return above;
}

/// Clusters as linked lists of their nodes: head[w], then next[u]; kAlone ends.
struct Lists {
  std::vector<std::int32_t> head, next;
};

/// Of each node the lower one of the pair that it is in: two that are each other's cheapest partner, at no more than
/// the limit. kAlone where it is in none. As what follows, without branches, for which pairs leave no pattern to
/// foresee.
std::vector<std::int32_t> pair_up(const Best& best, float limit, const Threads& threads) {
  const auto n = static_cast<std::int32_t>(best.partner.size());
  std::vector<std::int32_t> leader(static_cast<std::size_t>(n));
  threads.run(n, threads.pieces(n, 4 * kWorthAThread), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t u = begin; u < end; ++u) {
      const std::int32_t v = best.partner[u], other = best.partner[v == kAlone ? u : v];
      const std::int32_t paired = -static_cast<std::int32_t>((other == u) & (best.price[u] <= limit));
      leader[u] = (std::min(u, v) & paired) | (kAlone & ~paired);
    }
  });
  return leader;
}

/// Numbers the clusters by their first nodes.
/// \param satellites  nodes whose partner is in a pair join it
/// \param map  is set to the cluster of each node
Lists number_clusters(const Best& best, const std::vector<std::int32_t>& leader, bool satellites,
                      std::vector<std::int32_t>& map) {
  const auto n = static_cast<std::int32_t>(leader.size());
  Lists lists{std::vector<std::int32_t>(leader.size()), std::vector<std::int32_t>(leader.size())};
  std::vector<std::int32_t> joins(leader.size());  // satellites
  map.resize(leader.size());
  std::int32_t clusters = 0, joining = 0;
  for (std::int32_t u = 0; u < n; ++u) {
    const std::int32_t v = best.partner[u], first = leader[u];
    const bool alone = first == kAlone, leads = first == u;
    const bool joined = satellites & alone & (leader[v == kAlone ? u : v] != kAlone);
    lists.next[u] = leads ? v : kAlone;
    lists.head[clusters] = joins[joining] = u;
    map[u] = clusters;
    map[u] = map[alone ? u : first];
    clusters += static_cast<std::int32_t>(leads | (alone & !joined));
    joining += static_cast<std::int32_t>(joined);
  }
  lists.head.resize(static_cast<std::size_t>(clusters));
  while (joining-- > 0) {  // from behind, so that each cluster lists its own in rising order
    const std::int32_t u = joins[joining], first = leader[best.partner[u]], second = best.partner[first];
    map[u] = map[first];
    lists.next[u] = std::exchange(lists.next[second], u);
  }
  return lists;
}

/// Sums and neighbours of the clusters from `begin` to `end`.
/// \return the rows; their lengths go to result.first
std::vector<std::int32_t> contract_between(const MergeGraph& graph, const std::vector<std::int32_t>& map,
                                           const Lists& lists, std::int32_t begin, std::int32_t end, MergeGraph& result,
                                           Job& job) {
  std::size_t room = 1;  // one spare, written to before it is known to be wanted
  for (std::int32_t w = begin; w < end; ++w)
    for (std::int32_t u = lists.head[w]; u != kAlone; u = lists.next[u]) room += graph.around(u).size();
  const auto rows = std::make_unique_for_overwrite<std::int32_t[]>(room);
  std::vector<std::int32_t> seen(lists.head.size(), kAlone);  // last cluster that listed each
  std::size_t out = 0;
  for (std::int32_t w = begin; w < end; ++w) {
    if ((w & 0x3fff) == 0) job.poll();
    const std::int32_t head = lists.head[w];
    const std::size_t start = out;
    NodeSum sum;
    seen[w] = w;
    for (std::int32_t u = head; u != kAlone; u = lists.next[u]) {
      const NodeSum& s = graph.sum[u];
      sum.x += s.x;
      sum.y += s.y;
      sum.z += s.z;
      for (const std::int32_t v : graph.around(u)) {
        const std::int32_t other = map[v];
        rows[out] = other;
        out += seen[other] != w ? 1 : 0;
        seen[other] = w;
      }
    }
    sum.length =
        lists.next[head] == kAlone ? graph.sum[head].length : std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    result.sum[w] = sum;
    result.first[w + 1] = static_cast<std::int32_t>(out - start);
    if (!graph.part.empty()) result.part[w] = graph.part[head];
  }
  return {rows.get(), rows.get() + out};
}

MergeGraph contract_lists(const MergeGraph& graph, const std::vector<std::int32_t>& map, const Lists& lists,
                          const Threads& threads, Job& job) {
  MergeGraph result;
  const auto clusters = static_cast<std::int32_t>(lists.head.size());
  result.sum.resize(lists.head.size());
  result.first.assign(lists.head.size() + 1, 0);
  if (!graph.part.empty()) result.part.resize(lists.head.size());
  const std::int32_t pieces = threads.pieces(clusters, kWorthAThread);
  std::vector<std::vector<std::int32_t>> rows(static_cast<std::size_t>(pieces));
  threads.run(clusters, pieces, [&](std::int32_t k, std::int32_t begin, std::int32_t end) {
    rows[k] = contract_between(graph, map, lists, begin, end, result, job);
  });
  result.neighbour = std::move(rows[0]);
  for (std::int32_t k = 1; k < pieces; ++k)
    result.neighbour.insert(result.neighbour.end(), rows[k].begin(), rows[k].end());
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  return result;
}

}  // namespace

MergeGraph merge_round(const MergeGraph& graph, bool satellites, std::int32_t least, std::vector<std::int32_t>& map,
                       const Threads& threads, Job& job) {
  const Best best = find_partners(graph, parts_above(graph, satellites ? 3 * least : 2 * least), threads, job);
  const float limit = satellites ? std::numeric_limits<float>::infinity() : gate(best);
  const Lists lists = number_clusters(best, pair_up(best, limit, threads), satellites, map);
  return contract_lists(graph, map, lists, threads, job);
}

namespace {

/// Greedy merging. Every cluster keeps its cheapest partner, and a heap holds one live entry a cluster.
///
/// After a merge the partners of the clusters around may be out of date. Where the new cluster is cheaper than what one
/// has, it is taken over at once. Else what one has was cheaper than anything that is left, so that its old price is a
/// lower bound: it may stay in the heap, and is looked up anew when it comes out.
/// \tparam kInside  whether nodes at the border of the graph count as parts of larger ones
template <bool kInside>
class Greedy {
 public:
  Greedy(const MergeGraph& graph, std::span<const RegionSum> sums, std::span<const std::int32_t> need,
         std::span<const std::uint8_t> border = {})
      : need_(need),
        row_(graph.neighbour),
        border_(graph.border),
        node_(sums.size()),
        seen_(sums.size(), kAlone),
        place_(sums.size(), 0),
        left_(need.size(), 0) {
    border_.resize(row_.size(), 0.0);
    room_ = 4 * row_.size();
    const std::int32_t n = graph.size();
    for (std::int32_t u = 0; u < n; ++u) {
      Node& node = node_[u];
      node = {sums[u].x, sums[u].y, sums[u].z, sums[u].length()};
      node.parent = u;
      node.first = graph.first[u];
      node.last = graph.first[u + 1];
      node.part = need.size() == 1 ? 0 : graph.part_of(u);
      node.live = sums[u].faces > 0;
      node.goes_on = kInside && border[u] != 0;
      if (!node.live) continue;
      ++clusters_;
      ++left_[node.part];
    }
    heap_.reserve(2 * static_cast<std::size_t>(n));
    for (std::int32_t u = 0; u < n; ++u)
      if (node_[u].live && find_partner(u)) heap_.push_back({node_[u].price, u});
    std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
  }

  /// \param limit  merging ends before a price above it
  /// \param steps  if given, gets what was merged
  void run(std::int32_t target, double limit, std::vector<MergeStep>* steps, Job& job) {
    std::uint32_t polled = 0;
    while (clusters_ > target && !heap_.empty()) {
      if ((++polled & 0x3ff) == 0) job.poll();
      std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
      const auto [price, u] = heap_.back();
      heap_.pop_back();
      const Node& node = node_[u];
      if (!node.live || price != node.price) continue;  // merged, or another entry has taken its place
      if (price > limit) break;
      if (left_[node.part] <= need_[node.part]) continue;
      const std::int32_t v = node.partner;
      if (node_[v].live && node_[v].version == node.partner_version) {
        if (kInside && node.goes_on && node_[v].goes_on) continue;  // waits until something cheaper comes
        if (steps != nullptr) steps->push_back({u, v, price});
        merge(u, v);
      } else if (find_partner(u)) {
        push(u);
      }
    }
  }

  std::vector<std::int32_t> clusters() {
    std::vector<std::int32_t> number(node_.size(), kNone), result(node_.size(), kNone);
    std::int32_t count = 0;
    for (std::size_t u = 0; u < node_.size(); ++u) {
      const std::int32_t root = find(static_cast<std::int32_t>(u));
      if (!node_[root].live) continue;
      if (number[root] == kNone) number[root] = count++;
      result[u] = number[root];
    }
    return result;
  }

 private:
  struct Node {
    double x, y, z, length;
    double price = 0;
    std::int32_t partner = kAlone, partner_version = 0, version = 0;
    std::int32_t first = 0, last = 0;  // its neighbours in row_; may name clusters that have merged since
    std::int32_t parent = 0, part = 0;
    bool live = false;
    bool goes_on = false;  // beyond the border of the graph
  };
  using Entry = std::pair<double, std::int32_t>;  // price, cluster

  [[nodiscard]] static double price_of(const Node& a, const Node& b) {
    if constexpr (kInside)
      if (a.goes_on != b.goes_on) return a.goes_on ? price_beside(a, b) : price_beside(b, a);
    const double x = a.x + b.x, y = a.y + b.y, z = a.z + b.z, lengths = a.length + b.length;
    // The second term lets small clusters merge first where all is flat.
    return lengths - std::sqrt(x * x + y * y + z * z) + 1e-12 * lengths;
  }
  /// As price_of, with a node of which only a part is known: as if the rest were endless, and in the same plane.
  [[nodiscard]] static double price_beside(const Node& part, const Node& b) {
    if (!(part.length > 0)) return b.length;
    return b.length - (part.x * b.x + part.y * b.y + part.z * b.z) / part.length + 1e-12 * (part.length + b.length);
  }
  std::int32_t find(std::int32_t u) {
    while (node_[u].parent != u) u = node_[u].parent = node_[node_[u].parent].parent;
    return u;
  }
  void push(std::int32_t u) {
    heap_.emplace_back(node_[u].price, u);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  void take_partner(std::int32_t u, std::int32_t v, double price) {
    node_[u].price = price;
    node_[u].partner = v;
    node_[u].partner_version = node_[v].version;
  }
  /// The cheapest partner of a cluster, ties to the lower number; false if it has no neighbour.
  bool find_partner(std::int32_t u) {
    Node& node = node_[u];
    double least = std::numeric_limits<double>::infinity();
    std::int32_t partner = kAlone;
    tidy(u);
    for (std::int32_t k = node.first; k < node.last; ++k) {
      const std::int32_t v = row_[k];
      const double price = price_of(node, node_[v]) - border_[k];
      if (price > least || (price == least && v >= partner)) continue;
      least = price;
      partner = v;
    }
    if (partner == kAlone) return false;
    take_partner(u, partner, least);
    return true;
  }
  /// Has each neighbour that lives stand in a row once.
  void tidy(std::int32_t u) {
    Node& node = node_[u];
    ++stamp_;
    std::int32_t out = node.first;
    for (std::int32_t k = node.first; k < node.last; ++k) out += put(k, u, out) ? 1 : 0;
    node.last = out;
  }
  /// Writes entry k of a row to another place, unless its cluster stands there already or is u itself.
  /// \return whether it did
  bool put(std::int32_t k, std::int32_t u, std::int32_t place) {
    const std::int32_t v = find(row_[k]);
    if (v == u || !node_[v].live) return false;
    if (seen_[v] == stamp_) {
      border_[place_[v]] += border_[k];
      return false;
    }
    seen_[v] = stamp_;
    place_[v] = place;
    row_[place] = v;
    border_[place] = border_[k];
    return true;
  }
  void merge(std::int32_t u, std::int32_t v) {
    Node &into = node_[u], &from = node_[v];
    into.x += from.x;
    into.y += from.y;
    into.z += from.z;
    into.length = std::sqrt(into.x * into.x + into.y * into.y + into.z * into.z);
    from.parent = u;
    from.live = false;
    into.goes_on = into.goes_on || from.goes_on;
    ++into.version;
    --clusters_;
    --left_[into.part];
    ++stamp_;
    if (row_.size() > room_) compact();
    const auto begin = static_cast<std::int32_t>(row_.size());
    append(into, u);
    append(from, u);
    from.first = from.last = 0;
    into.first = begin;
    into.last = static_cast<std::int32_t>(row_.size());
    double least = std::numeric_limits<double>::infinity();
    std::int32_t partner = kAlone;
    for (std::int32_t k = into.first; k < into.last; ++k) {
      const std::int32_t w = row_[k];
      const double price = price_of(into, node_[w]) - border_[k];
      if (price < least || (price == least && w < partner)) {
        least = price;
        partner = w;
      }
      if (price >= node_[w].price) continue;
      take_partner(w, u, price);
      push(w);
    }
    if (partner == kAlone) return;
    take_partner(u, partner, least);
    push(u);
  }
  /// Drops rows of clusters that have merged. A cluster with many neighbours leaves a long one each time it merges, so
  /// that without this the memory would grow with the square of their number.
  void compact() {
    std::vector<std::int32_t> row;
    std::vector<double> border;
    for (Node& node : node_) {
      const auto first = static_cast<std::int32_t>(row.size());
      if (node.first < node.last) {
        row.insert(row.end(), row_.begin() + node.first, row_.begin() + node.last);
        border.insert(border.end(), border_.begin() + node.first, border_.begin() + node.last);
      }
      node.first = first;
      node.last = static_cast<std::int32_t>(row.size());
    }
    row_ = std::move(row);
    border_ = std::move(border);
    room_ = std::max(room_, 2 * row_.size());
  }
  void append(const Node& node, std::int32_t u) {
    for (std::int32_t k = node.first; k < node.last; ++k) {
      row_.push_back(kAlone);
      border_.push_back(0);
      if (put(k, u, static_cast<std::int32_t>(row_.size()) - 1)) continue;
      row_.pop_back();
      border_.pop_back();
    }
  }

  std::span<const std::int32_t> need_;
  std::vector<std::int32_t> row_;
  std::vector<double> border_;  // as row_
  std::vector<Node> node_;
  std::vector<std::int32_t> seen_, place_, left_;
  std::vector<Entry> heap_;
  std::int32_t clusters_ = 0, stamp_ = 0;
  std::size_t room_ = 0;  // length of `row_` from which it is compacted
};

}  // namespace

std::vector<std::int32_t> merge_greedily(const MergeGraph& graph, std::span<const RegionSum> sums,
                                         std::span<const std::int32_t> need, std::int32_t target, Job& job) {
  Greedy<false> greedy(graph, sums, need);
  greedy.run(target, std::numeric_limits<double>::infinity(), nullptr, job);
  return greedy.clusters();
}

std::vector<MergeStep> merge_inside(const MergeGraph& graph, std::span<const RegionSum> sums,
                                    std::span<const std::int32_t> need, std::span<const std::uint8_t> border,
                                    std::int32_t target, double limit, Job& job) {
  Greedy<true> greedy(graph, sums, need, border);
  std::vector<MergeStep> steps;
  greedy.run(target, limit, &steps, job);
  return steps;
}

MergeGraph contract(const MergeGraph& graph, const std::vector<std::int32_t>& map, std::int32_t clusters,
                    const Threads& threads, Job& job) {
  Lists lists{std::vector<std::int32_t>(static_cast<std::size_t>(clusters), kAlone),
              std::vector<std::int32_t>(map.size(), kAlone)};
  for (auto u = static_cast<std::int32_t>(map.size()) - 1; u >= 0; --u)
    lists.next[u] = std::exchange(lists.head[map[u]], u);
  return contract_lists(graph, map, lists, threads, job);
}

}  // namespace isimp
