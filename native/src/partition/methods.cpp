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
#include "make_partition.h"
#include "parts.h"

namespace isimp {
namespace {

constexpr int kSmoothSweeps = 60;  // of the borders of regions that the detail gave

}  // namespace

bool needs_hierarchy(const PartitionOptions& options) {
  return options.method == Method::hierarchy ||
         (options.method != Method::hybrid && options.seeding == Seeding::hierarchical);
}

Partition by_number(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  const Parts parts = find_parts(surface, *options.proxies, options.leave_out, job, hierarchy.parts);
  const Regions regions = optimise(surface, hierarchy, parts, options.smooth, threads, job);
  Partition result = make_partition(surface, parts, regions, {regions.error()}, threads, job);
  result.smooth = options.smooth;
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
