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

// tuned unrecorded
constexpr float kGate = 0.7F;  // share of the nodes whose best price lets them merge
// tuned gates
constexpr float kWideGate = 64;                  // factor of the gate: the highest price when satellites join
constexpr float kTie = 1e-6F;                    // rounding: share of the lengths
constexpr std::int32_t kWorthAThread = 1 << 12;  // work: nodes

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

/// \param takes_part  by component: whether its nodes merge
/// \param most        the highest price of a merge
Best find_partners(const MergeGraph& graph, const std::vector<std::uint8_t>& takes_part, float most,
                   const Threads& threads, Job& job) {
  const std::int32_t n = graph.size();
  Best best{std::vector<std::int32_t>(n, kNone), std::vector<float>(n, std::numeric_limits<float>::infinity())};
  threads.run(n, threads.pieces(n, kWorthAThread), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t u = begin; u < end; ++u) {
      if ((u & 0x3fff) == 0) job.poll();
      if (takes_part[graph.component_of(u)] == 0) continue;
      const NodeSum a = graph.sum[u];
      float least = std::numeric_limits<float>::infinity();
      std::int32_t partner = kNone;
      for (const std::int32_t v : graph.around(u)) {
        const NodeSum b = graph.sum[v];
        const float lengths = a.length + b.length;
        const float price = lost_length(a, b, lengths) + tie_break(u, v, lengths);
        partner = price < least ? v : partner;
        least = price < least ? price : least;
      }
      if (least > most) continue;
      best.partner[u] = partner;
      best.price[u] = least;
    }
  });
  return best;
}

/// The price up to which pairs merge: the price at kGate of the way if all prices were sorted. Only the prices that
/// agree with it in their first bits are sorted.
float gate(const Best& best) {
  constexpr int kShift =
      20;  // work: leaves exponent and three digits; prices are not below 0, so their bits rise with them
  const auto bucket = [](float price) { return std::bit_cast<std::uint32_t>(std::max(0.0F, price)) >> kShift; };
  const std::uint32_t none = bucket(std::numeric_limits<float>::infinity());  // price of nodes that do not merge
  std::vector<std::size_t> count(none + 1, 0);
  for (const float price : best.price) ++count[bucket(price)];
  const std::size_t priced = best.price.size() - count[none];
  if (priced == 0) return 0.0F;
  auto rank = static_cast<std::size_t>(kGate * static_cast<float>(priced - 1));
  std::uint32_t of_rank = 0;
  while (rank >= count[of_rank]) rank -= count[of_rank++];
  std::vector<float> alike(count[of_rank] + 1);  // one spare, written before its use is known
  std::size_t out = 0;
  for (const float price : best.price) {
    alike[out] = price;
    out += bucket(price) == of_rank ? 1 : 0;
  }
  const auto at = alike.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(alike.begin(), at, alike.end() - 1);
  return *at;
}

/// For each component, whether it has more than `least` nodes.
std::vector<std::uint8_t> components_above(const MergeGraph& graph, std::int32_t least) {
  if (graph.component.empty()) return {graph.size() > least};
  std::vector<std::int32_t> nodes(
      static_cast<std::size_t>(1 + *std::max_element(graph.component.begin(), graph.component.end())));
  for (const std::int32_t c : graph.component) ++nodes[c];
  std::vector<std::uint8_t> above(nodes.size());
  for (std::size_t c = 0; c < nodes.size(); ++c) above[c] = nodes[c] > least ? 1 : 0;
  return above;
}

/// Clusters as linked lists of their nodes: head[w], then next[u]; kNone ends.
struct Lists {
  std::vector<std::int32_t> head, next;
};

/// Returns the lower node of the pair that each node is in, kNone if it is in none. A pair is two nodes that are each
/// other's cheapest partner, at no more than the limit. The code here and below has no branches, since no processor
/// predicts pairs.
std::vector<std::int32_t> pair_up(const Best& best, float limit, const Threads& threads) {
  const auto n = static_cast<std::int32_t>(best.partner.size());
  std::vector<std::int32_t> leader(static_cast<std::size_t>(n));
  threads.run(n, threads.pieces(n, 4 * kWorthAThread), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t u = begin; u < end; ++u) {
      const std::int32_t v = best.partner[u], other = best.partner[v == kNone ? u : v];
      const std::int32_t paired = -static_cast<std::int32_t>((other == u) & (best.price[u] <= limit));
      leader[u] = (std::min(u, v) & paired) | (kNone & ~paired);
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
    const bool alone = first == kNone, leads = first == u;
    const bool joined = satellites & alone & (leader[v == kNone ? u : v] != kNone);
    lists.next[u] = leads ? v : kNone;
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
  std::size_t room = 1;  // one spare, written before its use is known
  for (std::int32_t w = begin; w < end; ++w)
    for (std::int32_t u = lists.head[w]; u != kNone; u = lists.next[u]) room += graph.around(u).size();
  const auto rows = std::make_unique_for_overwrite<std::int32_t[]>(room);
  std::vector<std::int32_t> seen(lists.head.size(), kNone);  // last cluster that listed each
  std::size_t out = 0;
  for (std::int32_t w = begin; w < end; ++w) {
    if ((w & 0x3fff) == 0) job.poll();
    const std::int32_t head = lists.head[w];
    const std::size_t start = out;
    NodeSum sum;
    seen[w] = w;
    for (std::int32_t u = head; u != kNone; u = lists.next[u]) {
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
        lists.next[head] == kNone ? graph.sum[head].length : std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    result.sum[w] = sum;
    result.first[w + 1] = static_cast<std::int32_t>(out - start);
    if (!graph.component.empty()) result.component[w] = graph.component[head];
  }
  return {rows.get(), rows.get() + out};
}

MergeGraph contract_lists(const MergeGraph& graph, const std::vector<std::int32_t>& map, const Lists& lists,
                          const Threads& threads, Job& job) {
  MergeGraph result;
  const auto clusters = static_cast<std::int32_t>(lists.head.size());
  result.sum.resize(lists.head.size());
  result.first.assign(lists.head.size() + 1, 0);
  if (!graph.component.empty()) result.component.resize(lists.head.size());
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

MergeGraph merge_round(const MergeGraph& graph, const MergeRules& rules, std::vector<std::int32_t>& map,
                       const Threads& threads, Job& job) {
  const std::int32_t left_alone = (rules.satellites ? 3 : 2) * rules.least;
  Best best =
      find_partners(graph, components_above(graph, left_alone), static_cast<float>(rules.most / 2), threads, job);
  float limit = std::numeric_limits<float>::infinity();
  if (!rules.satellites) {
    limit = gate(best);
  } else if (rules.most == std::numeric_limits<double>::infinity()) {
    limit = kWideGate * gate(best);
    for (std::size_t u = 0; u < best.partner.size(); ++u)
      if (best.price[u] > limit) best.partner[u] = kNone;  // neither as a satellite
  }
  const Lists lists = number_clusters(best, pair_up(best, limit, threads), rules.satellites, map);
  return contract_lists(graph, map, lists, threads, job);
}

MergeGraph contract(const MergeGraph& graph, const std::vector<std::int32_t>& map, std::int32_t clusters,
                    const Threads& threads, Job& job) {
  Lists lists{std::vector<std::int32_t>(static_cast<std::size_t>(clusters), kNone),
              std::vector<std::int32_t>(map.size(), kNone)};
  for (auto u = static_cast<std::int32_t>(map.size()) - 1; u >= 0; --u)
    lists.next[u] = std::exchange(lists.head[map[u]], u);
  return contract_lists(graph, map, lists, threads, job);
}

}  // namespace isimp
