#include "isimp/partition/regions.h"

#include <algorithm>
#include <limits>

namespace isimp {

constexpr std::int32_t kPollEvery = 0xffff;

void sum_regions(const FaceGraph& graph, Regions& regions, Job& job) {
  std::fill(regions.sum.begin(), regions.sum.end(), RegionSum{});
  RegionSum run;  // faces near in the graph are often of one region: sum up a run before touching the region's own sum
  std::int32_t of_run = kNone;
  const std::int32_t n = graph.size();
  for (std::int32_t i = 0; i <= n; ++i) {  // the sentinel's label closes the last run
    if ((i & kPollEvery) == 0) job.poll();
    const std::int32_t r = regions.label[i];
    if (r != of_run) {
      if (of_run != kNone) regions.sum[of_run].add(run);
      run = RegionSum{};
      of_run = r;
    }
    if (r != kNone) run.add(graph.faces[i]);
  }
}

std::vector<std::int32_t> nearest_faces(const FaceGraph& graph, const Regions& regions, Job& job) {
  const auto count = static_cast<std::size_t>(regions.count());
  struct Nearest {
    NormalMetric::Proxy proxy;
    float error = std::numeric_limits<float>::infinity();
  };
  std::vector<Nearest> nearest(count);
  for (std::size_t r = 0; r < count; ++r) nearest[r].proxy = NormalMetric::fit(regions.sum[r]);
  std::vector<std::int32_t> face(count, kNone);
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    if ((i & kPollEvery) == 0) job.poll();
    const std::int32_t r = regions.label[i];
    if (r == kNone) continue;
    const float error = NormalMetric::error(graph.faces[i], nearest[r].proxy);
    if (error < nearest[r].error) {
      nearest[r].error = error;
      face[r] = i;
    }
  }
  return face;
}

}  // namespace isimp
