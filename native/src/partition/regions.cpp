#include "isimp/partition/regions.h"

#include <algorithm>
#include <limits>

#include "isimp/core/check.h"
#include "parts.h"

namespace isimp {
namespace {

// work: sums are taken block by block and then added up, so that their rounding does not depend on the number of threads.
constexpr std::int32_t kBlocks = 8;
constexpr std::size_t kManySums = 1 << 14;  // work: from here on the blocks' own sums would cost more than they save

void sum_between(const FaceGraph& graph, const std::vector<std::int32_t>& label, std::int32_t begin, std::int32_t end,
                 std::vector<RegionSum>& sums, Job& job) {
  RegionSum run;  // faces near in the graph are often of one region: sum up a run before touching the region's own sum
  std::int32_t of_run = kNone;
  const auto close = [&] {
    if (of_run != kNone) sums[of_run].add(run);
    run = RegionSum{};
  };
  for (std::int32_t i = begin; i < end; ++i) {
    if ((i & kPollMask) == 0) job.poll();
    const std::int32_t r = label[i];
    ISIMP_ASSERT(r >= kNone && r < static_cast<std::int32_t>(sums.size()), "labels are of regions");
    if (r != of_run) {
      close();
      of_run = r;
    }
    if (r != kNone) run.add(graph.faces[i]);
  }
  close();
}

/// The nearest face found for each region.
struct Nearest {
  std::vector<float> error;
  std::vector<std::int32_t> face;
};

}  // namespace

void sum_regions(const FaceGraph& graph, Regions& regions, Job& job, const Threads& threads) {
  const std::int32_t n = graph.size();
  const std::int32_t blocks = regions.sum.size() < kManySums ? kBlocks : 1;
  std::vector<std::vector<RegionSum>> sums(static_cast<std::size_t>(blocks));
  threads.run(blocks, threads.pieces(n, n / blocks + 1), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t b = begin; b < end; ++b) {
      sums[b].resize(regions.sum.size());
      const auto edge = [&](std::int64_t block) { return static_cast<std::int32_t>(n * block / blocks); };
      sum_between(graph, regions.label, edge(b), edge(b + 1), sums[b], job);
    }
  });
  regions.sum = std::move(sums[0]);
  for (std::int32_t b = 1; b < blocks; ++b)
    for (std::size_t r = 0; r < regions.sum.size(); ++r) regions.sum[r].add(sums[b][r]);
}

std::vector<std::int32_t> nearest_faces(const FaceGraph& graph, const Regions& regions, Job& job,
                                        const Threads& threads) {
  const auto count = static_cast<std::size_t>(regions.count());
  std::vector<NormalMetric::Proxy> proxy(count);
  for (std::size_t r = 0; r < count; ++r) proxy[r] = NormalMetric::fit(regions.sum[r]);
  const std::int32_t pieces = threads.pieces(graph.size(), 1 << 16);
  std::vector<Nearest> found(static_cast<std::size_t>(pieces));
  threads.run(graph.size(), pieces, [&](std::int32_t k, std::int32_t begin, std::int32_t end) {
    Nearest nearest{std::vector<float>(count, std::numeric_limits<float>::infinity()),
                    std::vector<std::int32_t>(count, kNone)};
    for (std::int32_t i = begin; i < end; ++i) {
      if ((i & kPollMask) == 0) job.poll();
      const std::int32_t r = regions.label[i];
      if (r == kNone) continue;
      const float error = NormalMetric::error(graph.faces[i], proxy[r]);
      if (error >= nearest.error[r]) continue;
      nearest.error[r] = error;
      nearest.face[r] = i;
    }
    found[k] = std::move(nearest);
  });
  for (std::int32_t k = 1; k < pieces; ++k)  // pieces in rising order, so that ties go to the lower index
    for (std::size_t r = 0; r < count; ++r)
      if (found[k].error[r] < found[0].error[r]) {
        found[0].error[r] = found[k].error[r];
        found[0].face[r] = found[k].face[r];
      }
  return std::move(found[0].face);
}

}  // namespace isimp
