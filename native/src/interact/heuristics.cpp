#include "isimp/interact/heuristics.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "dissolve.h"
#include "edit.h"
#include "isimp/core/errors.h"
#include "isimp/interact/merge.h"

namespace isimp {
namespace {

constexpr double kFlat = 1e-7;  // rounding: error below it, as a share of the whole area, is rounding

void check_times(std::int32_t times) {
  if (times < 1) throw InvalidInput("times must be at least 1, got " + std::to_string(times));
}

[[noreturn]] void out_of_regions(const char* what, std::int32_t done, std::int32_t times) {
  throw InvalidInput("only " + std::to_string(done) + " of " + std::to_string(times) +
                     " can be done: no region is left that could be " + what);
}

/// The decrease of the error by the best split of a region. Below 0: its faces can't be split.
double gain_of_split(Edit& edit, std::int32_t region) {
  const FaceGraph& graph = edit.graph;
  const std::vector<std::int32_t> faces =
      take_out(graph, edit.labels, graph.graph_face[edit.result.region_seed[region]]);
  const RegionSum& sum = edit.result.region_sum[region];
  // Without held regions, as there is no region yet for the new label.
  const EditLabels labels{edit.result.face_region.data(), &graph};
  const double gain =
      faces.size() < 2 ? -1.0
                       : split_gain(sum, split_in_two(graph, labels, faces, sum, {region, edit.result.region_count()}));
  for (const std::int32_t i : faces) edit.labels.set(i, region);
  return gain;
}

/// Finds the region whose split lowers the error most.
class Splits {
 public:
  /// \return the region; the one with the most faces if no split lowers the error; kNone if none can be split
  std::int32_t best(Edit& edit, Job& job) {
    std::vector<std::int32_t> order;  // by error, since no split gains more
    for (std::int32_t r = 0; r < edit.result.region_count(); ++r)
      if (!edit.locked(r) && edit.result.region_sum[r].faces > 1) order.push_back(r);
    const auto& sums = edit.result.region_sum;
    std::ranges::stable_sort(order, std::greater<>(), [&](std::int32_t r) { return sums[r].error(); });
    double most = kFlat;
    std::int32_t best = kNone;
    for (const std::int32_t r : order) {
      if (sums[r].error() <= most) break;
      job.poll();
      const double gain = gain_of(edit, r);
      if (gain > most || (gain == most && r < best)) best = r;
      most = std::max(most, gain);
    }
    if (best != kNone || order.empty()) return best;
    return *std::ranges::max_element(order, {}, [&](std::int32_t r) { return std::pair(sums[r].faces, -r); });
  }

 private:
  struct Known {
    double error = -1.0, gain = 0.0;
  };

  /// A gain holds as long as the error of its region does.
  double gain_of(Edit& edit, std::int32_t region) {
    known_.resize(edit.result.region_sum.size());
    const double error = edit.result.region_sum[region].error();
    if (known_[region].error != error) known_[region] = {error, gain_of_split(edit, region)};
    return known_[region].gain;
  }

  std::vector<Known> known_;
};

struct Pair {
  double cost;
  std::int32_t u, v;
  bool operator<(const Pair& o) const { return std::tie(cost, u, v) < std::tie(o.cost, o.u, o.v); }
};

/// Faces at the borders of regions; grows as borders move, so that no new search is needed.
class Borders {
 public:
  Borders(const Edit& edit, Job& job) {
    for (std::int32_t i = 0; i < edit.graph.size(); ++i) {
      if ((i & 0xffff) == 0) job.poll();
      const std::int32_t own = edit.labels.get(i);
      for (const std::int32_t j : edit.graph.neighbours[i])
        if (j != edit.graph.size() && edit.labels.get(j) != own) {
          faces_.push_back(i);
          break;
        }
    }
  }
  void add(const std::vector<std::int32_t>& faces) {
    faces_.insert(faces_.end(), faces.begin(), faces.end());
    std::sort(faces_.begin(), faces_.end());
    faces_.erase(std::unique(faces_.begin(), faces_.end()), faces_.end());
  }
  /// The pair of neighbours that costs least to merge.
  [[nodiscard]] Pair cheapest(const Edit& edit) const {
    Pair best{std::numeric_limits<double>::infinity(), kNone, kNone};
    std::pair<std::int32_t, std::int32_t> last(kNone, kNone);  // along a border the same pair occurs many times
    for (const std::int32_t i : faces_)
      for (const std::int32_t j : edit.graph.neighbours[i]) {
        const std::pair<std::int32_t, std::int32_t> pair = std::minmax(edit.labels.get(i), edit.labels.get(j));
        if (pair.first < 0 || pair.first == pair.second || pair == last) continue;
        last = pair;
        const double cost = merge_cost(edit.result.region_sum[pair.first], edit.result.region_sum[pair.second]);
        best = std::min(best, Pair{cost, pair.first, pair.second});
      }
    return best;
  }

 private:
  std::vector<std::int32_t> faces_;
};

}  // namespace

Partition add_worst(const Mesh& mesh, const Partition& partition, std::int32_t times, Job& job) {
  check_times(times);
  Partition result = partition;
  Splits splits;
  for (std::int32_t k = 0; k < times; ++k) {
    Job::Stage stage(job, "adding", static_cast<double>(k) / times, static_cast<double>(k + 1) / times);
    std::int32_t region = kNone;
    {
      Edit edit(mesh, result);
      region = splits.best(edit, job);
    }
    if (region == kNone) out_of_regions("split", k, times);
    result = split_region(mesh, result, result.region_seed[region], job);
  }
  return result;
}

Partition delete_least(const Mesh& mesh, const Partition& partition, std::int32_t times, Job& job) {
  check_times(times);
  Partition result = partition;
  std::vector<Borders> borders;
  for (std::int32_t k = 0; k < times; ++k) {
    Job::Stage stage(job, "deleting", static_cast<double>(k) / times, static_cast<double>(k + 1) / times);
    Edit edit(mesh, result);
    if (borders.empty()) borders.emplace_back(edit, job);
    const Pair pair = borders.front().cheapest(edit);
    if (pair.u == kNone) out_of_regions("deleted", k, times);
    // The smaller one of the two is dissolved.
    const auto& sums = edit.result.region_sum;
    const std::int32_t gone = sums[pair.v].length() < sums[pair.u].length() ? pair.v : pair.u;
    dissolve(edit, gone, edit.graph.graph_face[edit.result.region_seed[gone]], job);
    borders.front().add(edit.borders);
    result = edit.finish();
  }
  return result;
}

Partition merge_cheapest(const Mesh& mesh, const Partition& partition, std::int32_t times, Job& job) {
  check_times(times);
  Partition result = partition;
  std::vector<Borders> borders;
  for (std::int32_t k = 0; k < times; ++k) {
    Job::Stage stage(job, "merging", static_cast<double>(k) / times, static_cast<double>(k + 1) / times);
    Pair pair{};
    {
      Edit edit(mesh, result);
      if (borders.empty()) borders.emplace_back(edit, job);
      pair = borders.front().cheapest(edit);
    }
    if (pair.u == kNone) out_of_regions("merged", k, times);
    result = merge_regions(mesh, result, result.region_seed[pair.u], result.region_seed[pair.v], job);
  }
  return result;
}

}  // namespace isimp
