#include "rounds.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "borders/relax.h"
#include "components.h"
#include "hierarchy/optimise.h"
#include "hierarchy/teleport.h"
#include "isimp/core/errors.h"
#include "isimp/partition/regions.h"
#include "lloyd.h"
#include "make_partition.h"
#include "parallel_lloyd.h"
#include "seeding.h"

namespace isimp {
namespace {

constexpr int kRoundSweeps = 200;  // limit: sweeps of the borders between flooding and teleports
constexpr int kTries = 50;         // limit: teleports in a row without gain that end a round

/// Teleports until none helps. The borders are relaxed before and after, so the input is returned if it was better.
Regions teleport(const Surface& surface, const Components& components, Regions regions, std::vector<double>& history,
                 Job& job) {
  const FaceGraph& graph = surface.graph();
  Regions before = regions;
  std::vector<std::int32_t> component;
  if (components.all.size() > 1) {
    const std::vector<std::int32_t> faces = nearest_faces(graph, regions, job);
    for (const std::int32_t face : faces) component.push_back(surface.component()[graph.mesh_face[face]]);
  }
  Relaxation<GraphLabels> relaxation(graph, {regions.label.data()}, regions.sum, light_border_weight(regions.error()));
  for (std::int32_t i = 0; i < graph.size(); ++i) relaxation.push_if_border(i);
  relaxation.run(kRoundSweeps, job);
  Teleport moves(graph, components, regions, std::move(component), relaxation);
  moves.run(kTries, 1.0, job);
  if (regions.error() > before.error()) return before;
  history.push_back(regions.error());
  return regions;
}

std::vector<std::int32_t> first_seeds(const Surface& surface, const Hierarchy& hierarchy, const Components& components,
                                      const PartitionOptions& options, const Threads& threads, Job& job) {
  Job::Stage stage(job, "seeding", 0.0, 0.1);
  const std::vector<std::int32_t> share = share_out(components);
  switch (options.seeding) {
    case Seeding::random:
      return random_seeds(surface, components, share, options.seed, job);
    case Seeding::farthest:
      return farthest_seeds(surface, components, share, options.seed, job);
    case Seeding::hierarchical:
      return nearest_faces(surface.graph(), optimise(surface, hierarchy, components, 0.0, threads, job), job, threads);
  }
  throw InvalidInput("the seeding is none of those known");
}

Regions flood_in_rounds(const Surface& surface, std::vector<std::int32_t> seeds, const PartitionOptions& options,
                        parallel::Flooder* flooder, std::vector<double>& history, Job& job) {
  if (flooder == nullptr) return lloyd(surface.graph(), std::move(seeds), options.iterations, history, job);
  return parallel_lloyd(surface, *flooder, std::move(seeds), options, history, job);
}

}  // namespace

bool needs_flooder(const PartitionOptions& options) {
  return options.method == Method::naive || options.method == Method::queued;
}

Partition in_rounds(const Surface& surface, const Hierarchy& hierarchy, parallel::Flooder* flooder,
                    const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  const Components components =
      find_components(surface, *options.proxies, options.leave_out, job, hierarchy.components);
  std::vector<double> history;
  std::vector<std::int32_t> seeds = first_seeds(surface, hierarchy, components, options, threads, job);
  Regions regions = [&] {
    const Job::Stage rounds(job, "flooding", 0.1, options.method == Method::teleport ? 0.6 : 1.0);
    return flood_in_rounds(surface, std::move(seeds), options, flooder, history, job);
  }();
  if (options.method == Method::teleport) {
    const Job::Stage moves(job, "teleporting", 0.6, 1.0);
    regions = teleport(surface, components, std::move(regions), history, job);
  }
  if (history.empty()) history.push_back(regions.error());
  return make_partition(surface, components, regions, std::move(history), threads, job);
}

}  // namespace isimp
