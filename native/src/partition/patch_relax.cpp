#include "isimp/partition/patch_relax.h"

#include <cmath>

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
  void measure() { length = std::sqrt(x * x + y * y + z * z); }
};

class PatchRelaxation {
 public:
  PatchRelaxation(const MergeGraph& graph, std::vector<std::int32_t>& label, std::int32_t regions)
      : graph_(graph),
        label_(label),
        sum_(static_cast<std::size_t>(regions)),
        mark_(label.size(), 0),
        queued_(label.size(), 0) {
    for (std::int32_t u = 0; u < graph.size(); ++u)
      if (label[u] != kNone) sum_[label[u]].add(graph.sum[u], 1);
    for (Sum& s : sum_) s.measure();
    for (std::int32_t u = 0; u < graph.size(); ++u)
      for (const std::int32_t v : graph.around(u))
        if (label[u] != label[v]) push(u);
  }

  std::int64_t sweep(Job& job) {
    std::swap(queue_, current_);
    queue_.clear();
    std::int64_t moves = 0;
    std::uint32_t polled = 0;
    for (const std::int32_t u : current_) {
      if ((++polled & 0xfff) == 0) job.poll();
      queued_[u] = 0;
      const std::int32_t to = best_move(u);
      if (to == kNone || !may_leave(u)) continue;
      Sum &from = sum_[label_[u]], &into = sum_[to];
      from.add(graph_.sum[u], -1);
      into.add(graph_.sum[u], 1);
      from.measure();
      into.measure();
      label_[u] = to;
      ++moves;
      for (const std::int32_t v : graph_.around(u)) push(v);
    }
    return moves;
  }

 private:
  void push(std::int32_t u) {
    if (queued_[u] != 0) return;
    queued_[u] = 1;
    queue_.push_back(u);
  }

  [[nodiscard]] std::int32_t best_move(std::int32_t u) const {
    const std::int32_t own = label_[u];
    if (own == kNone || sum_[own].nodes <= 1) return kNone;
    const NodeSum& s = graph_.sum[u];
    const double leaving = sum_[own].length_with(s, -1.0) - sum_[own].length;
    double best = 1e-6 * s.length;
    std::int32_t to = kNone, last = kNone;
    for (const std::int32_t v : graph_.around(u)) {
      const std::int32_t other = label_[v];
      if (other == own || other == last) continue;
      last = other;
      const double gain = leaving + sum_[other].length_with(s, 1.0) - sum_[other].length;
      if (gain > best) {
        best = gain;
        to = other;
      }
    }
    return to;
  }

  /// Whether the neighbours of the same region are connected among themselves.
  bool may_leave(std::int32_t u) {
    const std::int32_t own = label_[u];
    ++stamp_;
    std::int32_t same = 0, start = kNone;
    for (const std::int32_t v : graph_.around(u))
      if (label_[v] == own) {
        mark_[v] = stamp_;
        ++same;
        start = v;
      }
    if (same <= 1) return same == 1;
    std::int32_t met = 1;
    mark_[start] = -stamp_;
    stack_.assign(1, start);
    while (!stack_.empty()) {
      const std::int32_t v = stack_.back();
      stack_.pop_back();
      for (const std::int32_t w : graph_.around(v))
        if (mark_[w] == stamp_) {
          mark_[w] = -stamp_;
          ++met;
          stack_.push_back(w);
        }
    }
    return met == same;
  }

  const MergeGraph& graph_;
  std::vector<std::int32_t>& label_;
  std::vector<Sum> sum_;
  std::vector<std::int32_t> mark_, queue_, current_, stack_;
  std::vector<std::uint8_t> queued_;
  std::int32_t stamp_ = 0;
};

}  // namespace

void relax_patches(const MergeGraph& graph, std::vector<std::int32_t>& label, std::int32_t regions, int sweeps,
                   Job& job) {
  PatchRelaxation relaxation(graph, label, regions);
  for (int k = 0; k < sweeps && relaxation.sweep(job) > 0; ++k) {
  }
}

}  // namespace isimp
