#include "methods.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "borders/relax.h"
#include "bound/bound.h"
#include "components.h"
#include "density/adaptivity.h"
#include "hierarchy/optimise.h"
#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/options.h"
#include "isimp/partition/noise.h"
#include "isimp/partition/regions.h"
#include "make_partition.h"

namespace isimp {
namespace {

constexpr int kSmoothSweeps = 60;  // limit: sweeps of the borders of regions from a detail

/// The number of given ways to choose the number of regions; two or more contradict each other.
void check_count(const Surface& surface, const PartitionOptions& options) {
  std::string given;
  const auto note = [&](bool is, const char* name) {
    if (is) given += (given.empty() ? "" : " and ") + std::string(name);
  };
  note(options.proxies.has_value(), "proxies");
  note(options.triangles.has_value(), "triangles");
  note(options.detail.has_value(), "detail");
  note(options.tolerance.has_value(), "tolerance");
  note(options.bound.has_value(), "bound");
  if (given.find(' ') != std::string::npos)
    throw InvalidInput(given + " are given, but each alone says how many regions there will be: give one of them");
  if (options.proxies && (*options.proxies < 1 || *options.proxies > surface.face_count()))
    throw InvalidInput("proxies must be in [1, " + std::to_string(surface.face_count()) + "], got " +
                       std::to_string(*options.proxies));
  if (options.bound && options.method != Method::hierarchy)
    throw InvalidInput("a bound is kept by method hierarchy only");
}

}  // namespace

void check(const Surface& surface, const PartitionOptions& options) {
  check_count(surface, options);
  check_fields(options);
}

bool needs_hierarchy(const PartitionOptions& options) {
  return options.method == Method::hierarchy ||
         (options.method != Method::hybrid && options.seeding == Seeding::hierarchical);
}

Partition by_number(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  const Components components =
      find_components(surface, *options.proxies, options.leave_out, job, hierarchy.components);
  const Regions regions =
      optimise(surface, hierarchy, components, options.smooth, threads, job, Finish::teleports, options.metric);
  Partition result = make_partition(surface, components, regions, {regions.error()}, threads, job);
  result.smooth = options.smooth;
  result.metric = options.metric;
  return result;
}

Partition by_bound(const Surface& surface, const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  Hierarchy hierarchy;
  {
    const Job::Stage merging(job, "merging", 0.0, 0.1);
    hierarchy = hierarchy_for_bound(surface, job, options.threads);
  }
  const Job::Stage fitting(job, "fitting planes", 0.1, 1.0);
  const Components components = find_components(surface, 1, options.leave_out, job, hierarchy.components);
  const BoundedRegions bounded = bounded_regions(surface, hierarchy, components, *options.bound, job);
  Partition result = make_partition(surface, components, bounded.regions, {bounded.regions.error()}, threads, job);
  result.proxies_asked = result.region_count();
  result.bound = *options.bound;
  result.noise = options.noise ? *options.noise : estimate_noise(surface.mesh(), Threads(options.threads), job);
  for (std::size_t r = 0; r < bounded.slab.size(); ++r) {
    const Slab& slab = bounded.slab[r];
    result.region_normal[r] = slab.normal;
    result.region_offset.push_back(slab.middle() + slab.normal.dot(surface.mesh().origin()));
    result.distance_max = std::max(result.distance_max, slab.width() / 2);
  }
  ISIMP_ASSERT(result.distance_max <= *options.bound * (1 + 1e-6), "every vertex is within the bound");
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
    tree.merge_again(surface, cut, regions, threads, job);
  }
  if (options.metric != Metric::normals) relax_by(options.metric, surface, regions, options.smooth, threads, job);
  Partition result = make_partition(surface, tree.components(), regions, {regions.error()}, threads, job);
  result.proxies_asked = result.region_count();
  result.tolerance = tolerance;
  result.noise = tree.noise();
  result.snapped = cut.snapped;
  result.smooth = options.smooth;
  result.metric = options.metric;
  return result;
}

Surface reweighted(const Surface& surface, const PartitionOptions& options, Job& job) {
  return surface.weighted(adaptive_weights(surface, options.adaptivity, Threads(options.threads), job));
}

Partition on_original_weights(const Surface& surface, Partition of_reweighted, const PartitionOptions& options,
                              Job& job) {
  const FaceGraph& graph = surface.graph();
  const Threads threads(options.threads);
  Regions regions;
  regions.label.assign(graph.faces.size(), kNone);
  for (std::int32_t i = 0; i < graph.size(); ++i) regions.label[i] = of_reweighted.face_region[graph.mesh_face[i]];
  regions.sum.resize(of_reweighted.region_sum.size());
  sum_regions(graph, regions, job, threads);
  Components components;
  components.asked = of_reweighted.proxies_asked;
  components.needed = of_reweighted.proxies_needed;
  components.left_out = of_reweighted.parts_left_out;
  components.area_left_out = of_reweighted.area_left_out;
  Partition result = make_partition(surface, components, regions, {regions.error()}, threads, job);
  if (of_reweighted.bound > 0) {
    result.region_normal = std::move(of_reweighted.region_normal);
    result.region_offset = std::move(of_reweighted.region_offset);
  }
  take_how_found(result, of_reweighted);
  if (result.bound > 0) restate_error(graph, result);
  return result;
}

}  // namespace isimp
