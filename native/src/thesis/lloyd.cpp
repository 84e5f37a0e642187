#include "lloyd.h"

#include <limits>
#include <utility>

#include "flooding.h"

namespace isimp {

Regions lloyd(const FaceGraph& graph, std::vector<std::int32_t> seeds, std::int32_t iterations,
              std::vector<double>& history, Job& job) {
  std::vector<NormalMetric::Proxy> proxies(seeds.size());
  for (std::size_t r = 0; r < seeds.size(); ++r) proxies[r] = NormalMetric::proxy_of(graph.faces[seeds[r]]);
  Flooding flooding;
  Regions now, best;
  now.sum.resize(seeds.size());
  std::vector<std::int32_t> before;
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t round = 0; round < iterations; ++round) {
    job.report(static_cast<double>(round) / iterations);
    std::swap(before, now.label);
    flooding.run(graph, proxies, seeds, now.label, job);
    if (now.label == before) break;  // the same labels would repeat for ever
    sum_regions(graph, now, job);
    history.push_back(now.error());
    if (history.back() < least) {
      least = history.back();
      best = now;
    }
    if (round + 1 == iterations) break;
    seeds = nearest_faces(graph, now, job);
    for (std::size_t r = 0; r < seeds.size(); ++r)
      if (now.sum[r].length() > 0) proxies[r] = NormalMetric::fit(now.sum[r]);  // else no area: its proxy stays
  }
  return best;
}

}  // namespace isimp
