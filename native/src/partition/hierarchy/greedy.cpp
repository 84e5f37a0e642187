#include "hierarchy/greedy.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "isimp/core/types.h"

namespace isimp {
namespace {

// work: A cluster with at least this many neighbours is a hub. All values from 32 to 1024 are about as fast; a scan without
// such clusters merges as if there were none.
constexpr std::int32_t kManyAround = 256;
constexpr double kPriceMargin = 0.125;  // work: share of the price, by which a lower bound is below it
constexpr double kRounding = 4e-16;     // rounding: share of the lengths in a price

/// Greedy merging. Every cluster stores its cheapest partner, and a heap holds one live entry a cluster.
///
/// After a merge the partners of the clusters around may be out of date. If the new cluster is cheaper than the stored
/// partner of a neighbour, it replaces that partner at once. Else the stored partner was cheaper than all others, so
/// that its old price is a lower bound: it may stay in the heap, and is searched for again when it comes out.
///
/// A cluster with many others around it is a hub. A check of all of them at each of its merges would take the square of
/// their number. But the price of a small cluster at a hub falls only as far as the hub turns, and a hub hardly turns.
/// So each cluster at a hub has a watch: the angle at which its price could fall below the stored one. Prices at a hub
/// are in the heap with a margin, so that they need not be right at once. A hub's own row names other hubs only; its
/// other pairs are in the rows, and among the prices, of the clusters around it.
class Greedy {
 public:
  Greedy(const MergeGraph& graph, std::span<const RegionSum> sums, std::span<const std::int32_t> need)
      : need_(need),
        row_(graph.neighbour),
        border_(graph.border),
        node_(sums.size()),
        seen_(sums.size(), kNone),
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
      node.component = need.size() == 1 ? 0 : graph.component_of(u);
      node.live = sums[u].faces > 0;
      if (!node.live) continue;
      ++clusters_;
      ++left_[node.component];
    }
    heap_.reserve(2 * static_cast<std::size_t>(n));
    for (std::int32_t u = 0; u < n; ++u)
      if (node_[u].live && find_partner(u)) heap_.push_back({node_[u].price, u});
    std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
    for (std::int32_t u = 0; u < n; ++u)
      if (node_[u].live && node_[u].around() > kManyAround) make_hub(u);
  }

  void run(std::int32_t target, Job& job) {
    std::uint32_t polled = 0;
    while (clusters_ > target && !heap_.empty()) {
      if ((++polled & 0x3ff) == 0) job.poll();
      std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
      const auto [price, u] = heap_.back();
      heap_.pop_back();
      const Node& node = node_[u];
      if (!node.live || price != node.price) continue;  // merged, or another entry has taken its place
      if (left_[node.component] <= need_[node.component]) continue;
      std::int32_t into = u, from = node.partner;
      if (node_[from].live && node_[from].version == node.partner_version) {
        if (is_hub(from)) std::swap(into, from);
        merge(into, from);
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
    std::int32_t partner = kNone, partner_version = 0, version = 0;
    std::int32_t first = 0, last = 0;  // its neighbours in row_; may name clusters that have merged since
    std::int32_t parent = 0, component = 0;
    std::int32_t hub = kNone;  // in hubs_
    std::int32_t watched = 0;  // the number of its newest watches
    bool live = false;
    [[nodiscard]] std::int32_t around() const { return last - first; }
    [[nodiscard]] Vec3 sum() const { return {x, y, z}; }
  };
  using PricedCluster = std::pair<double, std::int32_t>;  // price, cluster
  struct Watch {
    double turned;  // turn of the hub at which the price is checked again
    std::int32_t node, number;
    bool operator>(const Watch& o) const { return turned != o.turned ? turned > o.turned : node > o.node; }
  };
  struct Hub {
    double turned = 0;         // the angles of all its turns, radians
    std::vector<Watch> watch;  // a heap
    std::size_t room = 1024;   // number of watches at which outdated ones are dropped
  };

  [[nodiscard]] bool is_hub(std::int32_t u) const { return node_[u].hub != kNone; }

  [[nodiscard]] static double price_of(const Node& a, const Node& b) {
    const double lengths = a.length + b.length;
    // The second term makes small clusters merge first where all is flat.
    return lost_length(a, b, lengths) + 1e-12 * lengths;
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
    std::int32_t partner = kNone;
    bool beside_hub = false;
    tidy(u);
    for (std::int32_t k = node.first; k < node.last; ++k) {
      const std::int32_t v = row_[k];
      beside_hub |= is_hub(v);
      const double price = price_of(node, node_[v]) - border_[k];
      if (price > least || (price == least && v >= partner)) continue;
      least = price;
      partner = v;
    }
    if (partner == kNone) return false;
    settle(u, partner, least, beside_hub);
    return true;
  }
  /// Sets the cheapest partner of a node; at a hub with a margin below its price, and with watches.
  void settle(std::int32_t u, std::int32_t partner, double price, bool beside_hub) {
    take_partner(u, partner, price);
    if (is_hub(u)) return;
    if (is_hub(partner)) leave_margin(u);
    if (beside_hub) watch(u);
  }
  /// Turns the price of a cluster at a hub into a lower bound, unless it is the next one that will merge.
  void leave_margin(std::int32_t u) {
    Node& node = node_[u];
    const double above = heap_.empty() ? 0.0 : node.price - heap_.front().first;
    const double margin = std::min(kPriceMargin * std::abs(node.price), above / 2);
    if (!(margin > kRounding * (node.length + node_[node.partner].length))) return;
    node.price -= margin;
    node.partner_version = kNone;  // its price is only a lower bound
  }
  /// The angle by which a hub can turn before its price for a node falls by `slack`.
  ///
  /// The price is |h| + |b| - |h + b| for the sums h of the hub and b of the node. It does not fall while |h| grows. While
  /// the hub turns by an angle a, it falls by at most |h| / |h + b| (across a + |b| a^2 / 2), where `across` is the part of
  /// b at right angles to h; the first factor is at most 2 where |b| is at most half of |h|.
  [[nodiscard]] static double turn_for(const Node& hub, const Node& b, double slack) {
    slack -= kRounding * (hub.length + b.length);
    if (!(slack > 0) || b.length > hub.length / 2) return 0;
    const double across = hub.sum().cross(b.sum()).norm() / hub.length;
    const double sum = across + std::sqrt(across * across + b.length * slack);
    return sum > 0 ? slack / sum : std::numeric_limits<double>::infinity();
  }
  /// Sets watches at the hubs next to a node, whose row is tidy. The older ones no longer count.
  void watch(std::int32_t u) {
    Node& node = node_[u];
    ++node.watched;
    for (std::int32_t k = node.first; k < node.last; ++k) {
      const Node& beside = node_[row_[k]];
      if (beside.hub == kNone) continue;
      Hub& hub = hubs_[beside.hub];
      const double slack = price_of(node, beside) - border_[k] - node.price;
      hub.watch.push_back({hub.turned + turn_for(beside, node, slack), u, node.watched});
      std::push_heap(hub.watch.begin(), hub.watch.end(), std::greater<>());
      if (hub.watch.size() > hub.room) drop_old_watches(hub);
    }
  }
  [[nodiscard]] bool counts(const Watch& w) const {
    return node_[w.node].live && !is_hub(w.node) && node_[w.node].watched == w.number;
  }
  void drop_old_watches(Hub& hub) {
    std::erase_if(hub.watch, [&](const Watch& w) { return !counts(w); });
    std::make_heap(hub.watch.begin(), hub.watch.end(), std::greater<>());
    hub.room = std::max(hub.room, 2 * hub.watch.size());
  }
  /// Sets a hub as partner if it has become cheaper than the stored partner, and renews the watches.
  void look_again(std::int32_t u) {
    Node& node = node_[u];
    tidy(u);
    bool cheaper = false;
    for (std::int32_t k = node.first; k < node.last; ++k) {
      const std::int32_t v = row_[k];
      if (!is_hub(v)) continue;
      const double price = price_of(node, node_[v]) - border_[k];
      if (price >= node.price) continue;
      take_partner(u, v, price);
      cheaper = true;
    }
    if (cheaper) {
      leave_margin(u);
      push(u);
    }
    watch(u);
  }
  /// \pre the row of u is tidy
  void make_hub(std::int32_t u) {
    node_[u].hub = static_cast<std::int32_t>(hubs_.size());
    hubs_.emplace_back();
    std::int32_t out = node_[u].first;
    for (std::int32_t k = node_[u].first; k < node_[u].last; ++k) {
      const std::int32_t v = row_[k];
      const double border = border_[k];
      if (is_hub(v)) {
        add_to_row(v, u, border);
        row_[out] = v;
        border_[out++] = border;
      } else if (node_[v].partner == u && find_partner(v)) {
        push(v);
      } else {
        tidy(v);
        watch(v);
      }
    }
    node_[u].last = out;
    offer_hub(u);
  }
  void add_to_row(std::int32_t u, std::int32_t v, double border) {
    const auto begin = static_cast<std::int32_t>(row_.size());
    ++stamp_;
    append(node_[u], u);
    row_.push_back(v);
    border_.push_back(border);
    node_[u].first = begin;
    node_[u].last = static_cast<std::int32_t>(row_.size());
  }
  /// Puts a hub's cheapest pair with another hub into the heap, and updates these hubs.
  void offer_hub(std::int32_t u) {
    if (!find_partner(u)) {
      node_[u].price = std::numeric_limits<double>::infinity();
      return;
    }
    push(u);
    for (std::int32_t k = node_[u].first; k < node_[u].last; ++k) {
      const std::int32_t v = row_[k];
      const double price = price_of(node_[u], node_[v]) - border_[k];
      if (price >= node_[v].price) continue;
      take_partner(v, u, price);
      push(v);
    }
  }
  /// Removes dead and repeated neighbours from a row.
  void tidy(std::int32_t u) {
    Node& node = node_[u];
    ++stamp_;
    std::int32_t out = node.first;
    for (std::int32_t k = node.first; k < node.last; ++k) out += put(k, u, out) ? 1 : 0;
    node.last = out;
  }
  /// Writes entry k of a row to another place, unless its cluster is already there or is u itself.
  /// \return whether it was written
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
    const Vec3 before = into.sum();
    into.x += from.x;
    into.y += from.y;
    into.z += from.z;
    into.length = std::sqrt(into.x * into.x + into.y * into.y + into.z * into.z);
    from.parent = u;
    from.live = false;
    ++into.version;
    --clusters_;
    --left_[into.component];
    if (row_.size() > room_) compact();
    if (is_hub(u)) {
      merge_hub(u, v, before);
      return;
    }
    ++stamp_;
    const auto begin = static_cast<std::int32_t>(row_.size());
    append(into, u);
    append(from, u);
    from.first = from.last = 0;
    into.first = begin;
    into.last = static_cast<std::int32_t>(row_.size());
    double least = std::numeric_limits<double>::infinity();
    std::int32_t partner = kNone;
    bool beside_hub = false;
    for (std::int32_t k = into.first; k < into.last; ++k) {
      const std::int32_t w = row_[k];
      const double price = price_of(into, node_[w]) - border_[k];
      if (price < least || (price == least && w < partner)) {
        least = price;
        partner = w;
      }
      beside_hub |= is_hub(w);
      if (is_hub(w) || price >= node_[w].price) continue;
      take_partner(w, u, price);
      push(w);
    }
    if (partner == kNone) return;
    settle(u, partner, least, beside_hub);
    push(u);
    if (into.around() > kManyAround) make_hub(u);
  }
  /// Updates the neighbours after a node was merged into a hub.
  /// \param before  sum of the hub before that
  void merge_hub(std::int32_t u, std::int32_t v, const Vec3& before) {
    tidy(v);
    std::vector<std::int32_t> near;  // nodes to check
    const std::vector<std::int32_t> row(row_.begin() + node_[v].first, row_.begin() + node_[v].last);
    const std::vector<double> border(border_.begin() + node_[v].first, border_.begin() + node_[v].last);
    for (std::size_t k = 0; k < row.size(); ++k)
      if (row[k] == u) {
        continue;
      } else if (!is_hub(row[k])) {
        near.push_back(row[k]);
      } else {
        add_to_row(u, row[k], border[k]);
        if (!is_hub(v)) add_to_row(row[k], u, border[k]);
      }
    node_[v].first = node_[v].last = 0;
    Hub& hub = hubs_[node_[u].hub];
    const Vec3 now = node_[u].sum();
    const double turn = std::atan2(before.cross(now).norm(), before.dot(now));
    hub.turned += turn;
    const bool all = is_hub(v) || now.norm() < before.norm();
    while (!hub.watch.empty() && (all || hub.watch.front().turned <= hub.turned)) {
      std::pop_heap(hub.watch.begin(), hub.watch.end(), std::greater<>());
      if (counts(hub.watch.back())) near.push_back(hub.watch.back().node);
      hub.watch.pop_back();
    }
    if (is_hub(v)) {
      for (const Watch& w : hubs_[node_[v].hub].watch)
        if (counts(w)) near.push_back(w.node);
      hubs_[node_[v].hub].watch = {};
    }
    for (const std::int32_t w : near) look_again(w);
    offer_hub(u);
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
      row_.push_back(kNone);
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
  std::vector<Hub> hubs_;
  std::vector<std::int32_t> seen_, place_, left_;
  std::vector<PricedCluster> heap_;
  std::int32_t clusters_ = 0, stamp_ = 0;
  std::size_t room_ = 0;  // length of `row_` from which it is compacted
};

}  // namespace

std::vector<std::int32_t> merge_greedily(const MergeGraph& graph, std::span<const RegionSum> sums,
                                         std::span<const std::int32_t> need, std::int32_t target, Job& job) {
  Greedy greedy(graph, sums, need);
  greedy.run(target, job);
  return greedy.clusters();
}

}  // namespace isimp
