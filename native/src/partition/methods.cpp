// Cohen-Steiner, Alliez, Desbrun: Variational Shape Approximation, 2004.

#include "methods.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "borders/relax.h"
#include "bound/bound.h"
#include "density/noise.h"
#include "hierarchy/optimise.h"
#include "isimp/core/errors.h"
#include "isimp/partition/regions.h"
#include "lloyd/lloyd.h"
#include "lloyd/parallel_lloyd.h"
#include "lloyd/seeding.h"
#include "lloyd/teleport.h"
#include "make_partition.h"
#include "parts.h"

namespace isimp {
namespace {

constexpr int kSweeps = 200;       // of the borders between flooding and teleports
constexpr int kSmoothSweeps = 60;  // of the borders of regions that the detail gave
constexpr int kTries = 50;         // of teleports in a row that do not pay, before a round ends

/// Teleports until none helps. The borders are relaxed before and after, so what comes in is given back if it was
/// better.
Regions teleport(const Surface& surface, const Parts& parts, Regions regions, std::vector<double>& history, Job& job) {
  const FaceGraph& graph = surface.graph();
  Regions before = regions;
  std::vector<std::int32_t> part;
  if (parts.parts.size() > 1) {
    const std::vector<std::int32_t> faces = nearest_faces(graph, regions, job);
    for (const std::int32_t face : faces) part.push_back(surface.component()[graph.mesh_face[face]]);
  }
  Relaxation<GraphLabels> relaxation(graph, {regions.label.data()}, regions.sum, light_border_weight(regions.error()));
  for (std::int32_t i = 0; i < graph.size(); ++i) relaxation.push_if_border(i);
  relaxation.run(kSweeps, job);
  Teleport moves(graph, parts, regions, std::move(part), relaxation);
  moves.run(kTries, 1.0, job);
  if (regions.error() > before.error()) return before;
  history.push_back(regions.error());
  return regions;
}

std::vector<std::int32_t> first_seeds(const Surface& surface, const Hierarchy& hierarchy, const Parts& parts,
                                      const PartitionOptions& options, const Threads& threads, Job& job) {
  Job::Part stage(job, "seeding", 0.0, 0.1);
  const std::vector<std::int32_t> share = share_out(parts);
  switch (options.seeding) {
    case Seeding::random:
      return random_seeds(surface, parts, share, options.seed, job);
    case Seeding::farthest:
      return farthest_seeds(surface, parts, share, options.seed, job);
    case Seeding::hierarchical:
      return nearest_faces(surface.graph(), optimise(surface, hierarchy, parts, 0.0, threads, job), job, threads);
  }
  throw InvalidInput("the seeding is none of those known");
}

Regions flood_in_rounds(const Surface& surface, std::vector<std::int32_t> seeds, const PartitionOptions& options,
                        parallel::Flooder* flooder, std::vector<double>& history, Job& job) {
  if (flooder == nullptr) return lloyd(surface.graph(), std::move(seeds), options.iterations, history, job);
  return parallel_lloyd(surface, *flooder, std::move(seeds), options, history, job);
}

}  // namespace

bool needs_hierarchy(const PartitionOptions& options) {
  return options.method == Method::hierarchy || options.seeding == Seeding::hierarchical;
}

bool needs_flooder(const PartitionOptions& options) {
  return options.method == Method::naive || options.method == Method::queued;
}

Partition by_number(const Surface& surface, const Hierarchy& hierarchy, parallel::Flooder* flooder,
                    const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  const Parts parts = find_parts(surface, *options.proxies, options.leave_out, job, hierarchy.parts);
  std::vector<double> history;
  Regions regions;
  if (options.method == Method::hierarchy) {
    regions = optimise(surface, hierarchy, parts, options.smooth, threads, job);
  } else {
    std::vector<std::int32_t> seeds = first_seeds(surface, hierarchy, parts, options, threads, job);
    const Job::Part rounds(job, "flooding", 0.1, options.method == Method::teleport ? 0.6 : 1.0);
    regions = flood_in_rounds(surface, std::move(seeds), options, flooder, history, job);
  }
  if (options.method == Method::teleport) {
    const Job::Part moves(job, "teleporting", 0.6, 1.0);
    regions = teleport(surface, parts, std::move(regions), history, job);
  }
  if (history.empty()) history.push_back(regions.error());
  Partition result = make_partition(surface, parts, regions, std::move(history), threads, job);
  if (options.method == Method::hierarchy) result.smooth = options.smooth;
  return result;
}

Partition by_bound(const Surface& surface, const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  Hierarchy hierarchy;
  {
    const Job::Part merging(job, "merging", 0.0, 0.1);
    hierarchy = hierarchy_for_bound(surface, job, options.threads);
  }
  const Job::Part fitting(job, "fitting planes", 0.1, 1.0);
  const Parts parts = find_parts(surface, 1, options.leave_out, job, hierarchy.parts);
  const BoundedRegions bounded = bounded_regions(surface, hierarchy, parts, *options.bound, job);
  Partition result = make_partition(surface, parts, bounded.regions, {bounded.regions.error()}, threads, job);
  result.proxies_asked = result.region_count();
  result.bound = *options.bound;
  result.noise = options.noise ? *options.noise : estimate_noise(surface.mesh(), job);
  for (std::size_t r = 0; r < bounded.slab.size(); ++r) {
    const Slab& slab = bounded.slab[r];
    result.region_normal[r] = slab.normal;
    result.region_offset.push_back(slab.middle());
    result.distance_max = std::max(result.distance_max, slab.width() / 2);
  }
  restate_error(surface.graph(), result);
  return result;
}

DetailSettings detail_settings(const Surface& surface, const PartitionOptions& options) {
  const double detail =
      options.tolerance ? *options.tolerance / surface_size(surface.mesh()) : options.detail.value_or(kDefaultDetail);
  return {finest_for(detail), options.noise, options.leave_out};
}

Partition by_detail(const Surface& surface, const DetailTree& tree, const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  const double tolerance = options.tolerance.value_or(options.detail.value_or(kDefaultDetail) * tree.size());
  const Cut cut = tree.choose(tolerance, options.snap);
  Regions regions = tree.regions(surface, cut, threads, job);
  if (options.smooth > 0) {
    const FaceGraph& graph = surface.graph();
    const BorderWeight weight = border_weight(regions.error(), options.smooth, graph.size(), regions.count());
    relax_borders(graph, regions, weight, kSmoothSweeps, threads, job, surface.relative_weight());
  }
  Partition result = make_partition(surface, tree.parts(), regions, {regions.error()}, threads, job);
  result.proxies_asked = result.region_count();
  result.tolerance = tolerance;
  result.noise = tree.noise();
  result.snapped = cut.snapped;
  result.smooth = options.smooth;
  return result;
}

}  // namespace isimp
