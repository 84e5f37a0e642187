#include "hierarchy/patch_relax.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "borders/block_changes.h"
#include "borders/relax.h"

namespace isimp {
namespace {

struct Sum {
  double x = 0, y = 0, z = 0, length = 0;
  std::int32_t nodes = 0;
  [[nodiscard]] double length_with(const NodeSum& s, double sign) const {
    const double a = x + sign * s.x, b = y + sign * s.y, c = z + sign * s.z;
    return std::sqrt(a * a + b * b + c * c);
  }
  void add(const NodeSum& s, std::int32_t sign) {
    x += sign * static_cast<double>(s.x);
    y += sign * static_cast<double>(s.y);
    z += sign * static_cast<double>(s.z);
    nodes += sign;
  }
  void add(const Sum& s) {
    x += s.x;
    y += s.y;
    z += s.z;
    nodes += s.nodes;
  }
  void measure() { length = std::sqrt(x * x + y * y + z * z); }
};

/// The regions as seen from one block: their state at the start, with the changes by moves within the block.
struct BlockSums {
  BlockChanges<Sum, Sum> changes;
  const Sum& operator[](std::int32_t r) const { return changes.view(r); }
  void move(const NodeSum& s, std::int32_t from, std::int32_t to) {
    add(from, s, -1);
    add(to, s, 1);
  }
  void add(std::int32_t r, const NodeSum& s, std::int32_t sign) {
    auto [change, view] = changes.touch(r);
    change.add(s, sign);
    view.add(s, sign);
    view.measure();
  }
};

/// The regions for a single thread: moves show at once.
struct AllSums {
  std::vector<Sum>& sums;
  const Sum& operator[](std::int32_t r) const { return sums[r]; }
  void move(const NodeSum& s, std::int32_t from, std::int32_t to) const {
    sums[from].add(s, -1);
    sums[to].add(s, 1);
    sums[from].measure();
    sums[to].measure();
  }
};

/// A stretch of nodes whose labels may be read.
struct Stretch {
  std::int32_t begin, end;
  [[nodiscard]] bool holds(std::int32_t u) const {
    return static_cast<std::uint32_t>(u - begin) < static_cast<std::uint32_t>(end - begin);
  }
};

struct Block {
  std::vector<std::int32_t> current, queue, beyond, stack, near;
  std::vector<std::pair<std::int32_t, Sum>> changes;
  std::int32_t stamp = 0;
  std::int64_t moves = 0;
};

/// In blocks of nodes, as Relaxation does it with faces (relax.h).
class PatchRelaxation {
 public:
  PatchRelaxation(const MergeGraph& graph, std::vector<std::int32_t>& label, std::int32_t regions, double smooth,
                  const Threads& threads, Job& job)
      : graph_(graph),
        label_(label),
        threads_(threads),
        sum_(static_cast<std::size_t>(regions)),
        mark_(label.size(), 0),
        queued_(label.size(), 0),
        blocks_(static_cast<std::size_t>(graph.size() / kBlock + 1)) {
    for (std::int32_t u = 0; u < graph.size(); ++u) {
      if ((u & 0xffff) == 0) job.poll();
      if (label[u] != kNone) sum_[label[u]].add(graph.sum[u], 1);
    }
    double lengths = 0;
    for (Sum& s : sum_) {
      s.measure();
      lengths += s.length;
    }
    // Relative to a mean node's area, not a face's: two nodes share several edges, and later sweeps of faces smooth the
    // rest.
    border_ = border_weight(std::max(0.0, 2 * (1 - lengths)), smooth, graph.size(), regions).edge / graph.size();
    threads_.share(block_count(), [&](const auto& next) {
      for (std::int32_t b = next(); b < block_count(); b = next()) {
        job.poll();
        blocks_[b].stamp = b;
        for (std::int32_t u = nodes_of(b).begin; u < nodes_of(b).end; ++u) {
          bool border = false;
          for (const std::int32_t v : graph_.around(u)) border |= label_[u] != label_[v];
          if (border) push(u, blocks_[b]);
        }
      }
    });
  }

  std::int64_t sweep(Job& job) {
    threads_.share(block_count(), [&](const auto& next) {
      BlockSums sums{BlockChanges<Sum, Sum>(sum_)};
      for (std::int32_t b = next(); b < block_count(); b = next()) {
        Block& block = blocks_[b];
        std::swap(block.queue, block.current);
        block.queue.clear();
        block.beyond.clear();
        block.moves = go_through(block.current, block, sums, nodes_of(b), job);
        block.changes = sums.changes.take();
      }
    });
    for (const Block& block : blocks_)
      for (const auto& [region, change] : block.changes) sum_[region].add(change);
    for (const Block& block : blocks_)
      for (const auto& [region, unused] : block.changes) sum_[region].measure();
    AllSums sums{sum_};
    std::int64_t moves = 0;
    for (Block& block : blocks_) moves += block.moves + go_through(block.beyond, block, sums, {0, graph_.size()}, job);
    return moves;
  }

 private:
  static constexpr std::int32_t kBlock = 1 << 12;  // work: nodes

  [[nodiscard]] std::int32_t block_count() const { return static_cast<std::int32_t>(blocks_.size()); }
  [[nodiscard]] Stretch nodes_of(std::int32_t block) const {
    return {block * kBlock, std::min(graph_.size(), (block + 1) * kBlock)};
  }
  static std::int32_t block_of(std::int32_t u) { return u / kBlock; }
  void push(std::int32_t u, Block& block) {
    if (queued_[u] != 0) return;
    queued_[u] = 1;
    block.queue.push_back(u);
  }

  /// Nodes with neighbours outside the stretch are put aside in block.beyond.
  /// \return moves made
  template <class Sums>
  std::int64_t go_through(const std::vector<std::int32_t>& nodes, Block& block, Sums& sums, const Stretch& reach,
                          Job& job) {
    std::int64_t moves = 0;
    std::uint32_t polled = 0;
    for (const std::int32_t u : nodes) {
      if ((++polled & 0xfff) == 0) job.poll();
      const auto around = graph_.around(u);
      if (!std::all_of(around.begin(), around.end(), [&](std::int32_t v) { return reach.holds(v); })) {
        block.beyond.push_back(u);  // stays queued, so that it is queued once
        continue;
      }
      queued_[u] = 0;
      const std::int32_t to = best_move(u, sums, block.near);
      if (to == kNone || !may_leave(u, block, reach)) continue;
      sums.move(graph_.sum[u], label_[u], to);
      label_[u] = to;
      ++moves;
      for (const std::int32_t v : around) push(v, blocks_[block_of(v)]);
    }
    return moves;
  }

  /// \param near  for the labels of the neighbours, which are counted again and again
  template <class Sums>
  [[nodiscard]] std::int32_t best_move(std::int32_t u, const Sums& sums, std::vector<std::int32_t>& near) const {
    const std::int32_t own = label_[u];
    if (own == kNone || sums[own].nodes <= 1) return kNone;
    const NodeSum& s = graph_.sum[u];
    const double leaving = sums[own].length_with(s, -1.0) - sums[own].length;
    double best = 1e-6 * s.length;
    std::int32_t to = kNone, last = kNone;
    const auto around = graph_.around(u);
    near.resize(around.size());
    for (std::size_t k = 0; k < around.size(); ++k) near[k] = label_[around[k]];
    for (const std::int32_t other : near) {
      if (other == own || other == last) continue;
      last = other;
      std::int32_t shorter = 0;
      for (const std::int32_t r : near)
        shorter += static_cast<std::int32_t>(r == other) - static_cast<std::int32_t>(r == own);
      const double gain = leaving + sums[other].length_with(s, 1.0) - sums[other].length + border_ * shorter;
      if (gain > best) {
        best = gain;
        to = other;
      }
    }
    return to;
  }

  /// Whether the neighbours of the same region are connected among themselves.
  bool may_leave(std::int32_t u, Block& block, const Stretch& reach) {
    const std::int32_t own = label_[u];
    const std::int32_t stamp = block.stamp += block_count();  // unique among the blocks
    std::int32_t same = 0, start = kNone;
    for (const std::int32_t v : graph_.around(u))
      if (label_[v] == own) {
        mark_[v] = stamp;
        ++same;
        start = v;
      }
    if (same <= 1) return same == 1;
    std::int32_t met = 1;
    mark_[start] = -stamp;
    block.stack.assign(1, start);
    while (!block.stack.empty()) {
      const std::int32_t v = block.stack.back();
      block.stack.pop_back();
      for (const std::int32_t w : graph_.around(v))
        if (reach.holds(w) && mark_[w] == stamp) {
          mark_[w] = -stamp;
          ++met;
          block.stack.push_back(w);
        }
    }
    return met == same;
  }

  const MergeGraph& graph_;
  std::vector<std::int32_t>& label_;
  const Threads& threads_;
  std::vector<Sum> sum_;
  double border_ = 0;  // price of one more pair of neighbours in different regions
  std::vector<std::int32_t> mark_;
  std::vector<std::uint8_t> queued_;
  std::vector<Block> blocks_;
};

}  // namespace

void relax_patches(const MergeGraph& graph, std::vector<std::int32_t>& label, std::int32_t regions, double smooth,
                   int sweeps, const Threads& threads, Job& job) {
  PatchRelaxation relaxation(graph, label, regions, smooth, threads, job);
  for (int k = 0; k < sweeps && relaxation.sweep(job) > 0; ++k) {
  }
}

}  // namespace isimp
