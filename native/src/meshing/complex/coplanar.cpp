#include "complex/coplanar.h"

#include <algorithm>
#include <array>
#include <vector>

#include "complex/joins.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr std::int32_t kChartsAPoll = 1 << 10;  ///< work: charts from one poll to the next

class CoplanarJoiner {
 public:
  CoplanarJoiner(const State& state, Labels& labels, const Job& job)
      : s_(state), labels_(labels), job_(job), faces_(s_.labels.charts.size()), onto_(faces_.size(), kNone) {}

  void run() {
    find_onto();
    const std::vector<std::int32_t> order = largest_first();
    const auto& label = s_.labels.label;
    for (std::int32_t f = 0; f < s_.mesh.face_count(); ++f)
      if (label[f] != kNone && onto_[label[f]] != kNone) faces_[label[f]].push_back(f);
    std::vector<std::int32_t> takers;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i % kChartsAPoll == 0) job_.poll();
      if (const std::int32_t l = order[i]; onto_[l] != kNone) give(l, takers);
    }
    sort_unique(takers);
    for (const std::int32_t l : takers) labels_.charts.edit(l).region = s_.region_of(l, s_.labels.faces_of(l));
    drop_gone(labels_);
  }

 private:
  /// The order of two charts in one plane: the larger one is first.
  [[nodiscard]] bool is_before(std::int32_t a, std::int32_t b) const {
    return s_.planes[a].area > s_.planes[b].area || (s_.planes[a].area == s_.planes[b].area && a < b);
  }

  [[nodiscard]] bool in_one_plane(std::int32_t a, std::int32_t b) const {
    const Plane &p = s_.planes[a], &q = s_.planes[b];
    if (!(p.projected > 0) || !(q.projected > 0) || p.normal.dot(q.normal) < kSameWay) return false;
    const double off = kThickness * s_.mesh.diagonal();
    const Plane both = united(p, q);
    return both.normal.dot(both.spread * both.normal) <= off * off;
  }

  /// Finds, for each chart that may be united, its largest neighbour in its plane.
  void find_onto() {
    std::vector<std::array<std::int32_t, 2>> pairs;
    const Labels& labels = s_.labels;
    for (std::int32_t h = 0; h < 3 * s_.mesh.face_count(); ++h) {
      const std::int32_t l = labels.label[h / 3];
      if (l == kNone || labels.charts[l].cause == Cause::region) continue;
      const std::int32_t k = labels.across(h);
      if (k != kNone && labels.charts[k].region != labels.charts[l].region && is_before(k, l)) pairs.push_back({l, k});
    }
    sort_unique(pairs);
    for (const auto& [l, k] : pairs)
      if ((onto_[l] == kNone || is_before(k, onto_[l])) && in_one_plane(l, k)) onto_[l] = k;
  }

  [[nodiscard]] std::vector<std::int32_t> largest_first() const {
    std::vector<std::int32_t> order = numbers_below(s_.labels.chart_count());
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return is_before(a, b); });
    return order;
  }

  /// Unites a chart with its larger neighbour, or with the chart that has already absorbed that neighbour.
  void give(std::int32_t l, std::vector<std::int32_t>& takers) {
    std::int32_t to = onto_[l];
    while (s_.labels.charts[to].face == kNone) to = onto_[to];
    if (!may_give(s_, l, to, faces_[l])) return;
    for (const std::int32_t f : faces_[l]) labels_.label.set(f, to);
    labels_.charts.edit(l).face = kNone;
    takers.push_back(to);
  }

  const State& s_;
  Labels& labels_;
  const Job& job_;
  std::vector<std::vector<std::int32_t>> faces_;  // by chart that may be united, in rising order
  std::vector<std::int32_t> onto_;                // by chart: the neighbour that may absorb it, kNone if it stays
};

}  // namespace

void join_coplanar(const State& state, Labels& labels, const Job& job) { CoplanarJoiner(state, labels, job).run(); }

}  // namespace isimp::meshing
