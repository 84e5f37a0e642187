// Cohen-Steiner, Alliez, Desbrun: Variational Shape Approximation, 2004.

#include "isimp/partition/partition.h"

#include <sstream>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/parallel/backend.h"
#include "isimp/partition/adaptivity.h"
#include "isimp/partition/bound.h"
#include "isimp/partition/hierarchy.h"
#include "isimp/partition/inherited.h"
#include "isimp/partition/lloyd.h"
#include "isimp/partition/make_partition.h"
#include "isimp/partition/noise.h"
#include "isimp/partition/optimise.h"
#include "isimp/partition/parallel_lloyd.h"
#include "isimp/partition/parts.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/relax.h"
#include "isimp/partition/seeding.h"
#include "isimp/partition/teleport.h"

namespace isimp {
namespace {

constexpr int kSweeps = 200;  // of the borders between flooding and teleports
constexpr int kTries = 50;    // of teleports in a row that do not pay, before a round ends

template <class T>
[[noreturn]] void out_of_range(const char* name, const std::string& range, T value) {
  std::ostringstream text;
  text << name << " must be " << range << ", got " << value;
  throw InvalidInput(text.str());
}

/// How many of the ways to choose the number of regions are taken; more than one contradict each other.
void check_count(const Surface& surface, const PartitionOptions& options) {
  std::string given;
  const auto note = [&](bool is, const char* name) {
    if (is) given += (given.empty() ? "" : " and ") + std::string(name);
  };
  note(options.proxies.has_value(), "proxies");
  note(options.detail.has_value(), "detail");
  note(options.tolerance.has_value(), "tolerance");
  note(options.bound.has_value(), "bound");
  if (given.find(' ') != std::string::npos)
    throw InvalidInput(given + " are given, but each alone says how many regions there will be: give one of them");
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (options.proxies && (*options.proxies < 1 || *options.proxies > surface.face_count()))
    out_of_range("proxies", "in [1, " + std::to_string(surface.face_count()) + "]", *options.proxies);
  if (options.detail && !(*options.detail > 0 && *options.detail <= 1))
    out_of_range("detail", "in (0, 1]", *options.detail);
  if (options.tolerance && !positive(*options.tolerance))
    out_of_range("tolerance", "a finite length above 0", *options.tolerance);
  if (options.bound && !positive(*options.bound)) out_of_range("bound", "a finite length above 0", *options.bound);
  if (options.bound && options.method != Method::hierarchy)
    throw InvalidInput("a bound is kept by method hierarchy only");
  if (options.noise && !positive(*options.noise) && *options.noise != 0)
    out_of_range("noise", "a finite length, at least 0", *options.noise);
}

void check(const Surface& surface, const PartitionOptions& options) {
  check_count(surface, options);
  if (!(options.leave_out >= 0 && options.leave_out < 1)) out_of_range("leave_out", "in [0, 1)", options.leave_out);
  if (!(options.adaptivity >= 0 && options.adaptivity <= 1))
    out_of_range("adaptivity", "in [0, 1]", options.adaptivity);
  if (options.iterations < 1) out_of_range("iterations", "at least 1", options.iterations);
  if (options.threads < 0) out_of_range("threads", "at least 0", options.threads);
  if (options.nearest < 1 || options.nearest > parallel::Flooder::kMostNearest)
    out_of_range("nearest", "in [1, " + std::to_string(parallel::Flooder::kMostNearest) + "]", options.nearest);
  if (!(options.fraction > 0 && options.fraction <= 1)) out_of_range("fraction", "in (0, 1]", options.fraction);
  if (options.backend != "cpu") (void)parallel::backend(options.backend);
}

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
      return nearest_faces(surface.graph(), optimise(surface, hierarchy, parts, threads, job), job, threads);
  }
  throw InvalidInput("the seeding is none of those known");
}

bool is_parallel(Method method) { return method == Method::naive || method == Method::queued; }

Regions flood_in_rounds(const Surface& surface, std::vector<std::int32_t> seeds, const PartitionOptions& options,
                        parallel::Flooder* flooder, std::vector<double>& history, Job& job) {
  if (!is_parallel(options.method)) return lloyd(surface.graph(), std::move(seeds), options.iterations, history, job);
  std::unique_ptr<parallel::Flooder> own;
  if (flooder == nullptr) own = load(surface, options.backend);
  return parallel_lloyd(surface, own ? *own : *flooder, std::move(seeds), options, history, job);
}

}  // namespace

Partition make_partition(const Surface& surface, const Parts& parts, const Regions& regions,
                         std::vector<double> history, const Threads& threads, Job& job) {
  const FaceGraph& graph = surface.graph();
  Partition result;
  result.face_region.resize(static_cast<std::size_t>(graph.size()));
  threads.run(graph.size(), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i) {
      if ((i & 0xffff) == 0) job.poll();
      result.face_region[graph.mesh_face[i]] = regions.label[i];
    }
  });
  result.region_seed = nearest_faces(graph, regions, job, threads);
  for (std::int32_t& seed : result.region_seed) seed = graph.mesh_face[seed];
  result.region_normal.reserve(regions.sum.size());
  for (const RegionSum& s : regions.sum) result.region_normal.push_back(s.normal());

  result.region_sum = regions.sum;
  result.error = regions.error() * graph.area;
  result.history = std::move(history);
  for (double& error : result.history) error *= graph.area;
  result.proxies_asked = parts.asked;
  result.proxies_needed = parts.needed;
  result.parts_left_out = parts.left_out;
  result.area_left_out = parts.area_left_out;
  result.guided = surface.guided();
  return result;
}

namespace {

/// Measures the error from the normals there are, which with a bound need not be the mean ones.
void restate_error(const FaceGraph& graph, Partition& part) {
  double error = 0.0;
  for (std::size_t r = 0; r < part.region_sum.size(); ++r) {
    const RegionSum& s = part.region_sum[r];
    error += s.weight - 2 * part.region_normal[r].dot(Vec3(s.x, s.y, s.z));
  }
  part.error = std::max(0.0, error * graph.area);
  part.history = {part.error};
}

Partition partition_within(const Surface& surface, const PartitionOptions& options, Job& job) {
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

}  // namespace

Partition partition(const Surface& surface, const PartitionOptions& options, Job& job) {
  if (options.adaptivity == 0) return partition(surface, Hierarchy{}, options, job);
  const double share = adapting_share(options);
  const Surface finer = [&] {
    const Job::Part stage(job, "finding details", 0.0, share);
    return adapted(surface, options, job);
  }();
  const Job::Part stage(job, "partitioning", share, 1.0);
  return restated(surface, partition(finer, Hierarchy{}, options, job), options, job);
}

double adapting_share(const PartitionOptions& options) { return options.proxies ? 0.7 : 0.4; }

Surface adapted(const Surface& surface, const PartitionOptions& options, Job& job) {
  check(surface, options);
  return surface.weighted(adaptive_weights(surface, options.adaptivity, Threads(options.threads), job));
}

Partition restated(const Surface& surface, Partition of_adapted, const PartitionOptions& options, Job& job) {
  const FaceGraph& graph = surface.graph();
  const Threads threads(options.threads);
  Regions regions;
  regions.label.assign(graph.faces.size(), kNone);
  for (std::int32_t i = 0; i < graph.size(); ++i) regions.label[i] = of_adapted.face_region[graph.mesh_face[i]];
  regions.sum.resize(of_adapted.region_sum.size());
  sum_regions(graph, regions, job, threads);
  Parts parts;
  parts.asked = of_adapted.proxies_asked;
  parts.needed = of_adapted.proxies_needed;
  parts.left_out = of_adapted.parts_left_out;
  parts.area_left_out = of_adapted.area_left_out;
  Partition result = make_partition(surface, parts, regions, {regions.error()}, threads, job);
  if (of_adapted.bound > 0) {
    result.region_normal = std::move(of_adapted.region_normal);
    result.region_offset = std::move(of_adapted.region_offset);
    restate_error(graph, result);
  }
  take_how_found(result, of_adapted);
  return result;
}

Partition partition(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options, Job& job,
                    parallel::Flooder* flooder) {
  const std::optional<DetailSettings> settings = detail_settings(surface, options);
  if (options.method == Method::hybrid) throw InvalidInput("method hybrid is for hybrid(), which decimates first");
  Job::Part stage(job, "partitioning", 0.0, 1.0);
  if (options.bound) return partition_within(surface, options, job);
  if (settings) {
    const DetailTree tree = [&] {
      const Job::Part merging(job, "merging", 0.0, 0.8);
      return DetailTree(surface, *settings, job);
    }();
    const Job::Part rest(job, "relaxing", 0.8, 1.0);
    return partition(surface, tree, options, job);
  }
  const std::int32_t proxies = *options.proxies;
  const Threads threads(options.threads);
  const bool hierarchical = options.method == Method::hierarchy || options.seeding == Seeding::hierarchical;
  Hierarchy own;
  if (hierarchical && !hierarchy.serves(surface, proxies)) {
    Job::Part merging(job, "merging", 0.0, 0.4);
    own = build_hierarchy(surface, proxies, job, options.threads, nodes_for(proxies));
  }
  const Hierarchy& h = own.patches() > 0 ? own : hierarchy;
  const Parts parts =
      find_parts(surface, proxies, options.leave_out, job, hierarchical ? h.parts : std::vector<Part>{});
  std::vector<double> history;
  Regions regions;
  if (options.method == Method::hierarchy) {
    Job::Part relaxing(job, "relaxing", own.patches() > 0 ? 0.4 : 0.0, 1.0);
    regions = optimise(surface, h, parts, threads, job);
  } else {
    std::vector<std::int32_t> seeds = first_seeds(surface, h, parts, options, threads, job);
    Job::Part rounds(job, "flooding", 0.1, options.method == Method::teleport ? 0.6 : 1.0);
    regions = flood_in_rounds(surface, std::move(seeds), options, flooder, history, job);
  }
  if (options.method == Method::teleport) {
    Job::Part moves(job, "teleporting", 0.6, 1.0);
    regions = teleport(surface, parts, std::move(regions), history, job);
  }
  if (history.empty()) history.push_back(regions.error());
  return make_partition(surface, parts, regions, std::move(history), threads, job);
}

std::optional<DetailSettings> detail_settings(const Surface& surface, const PartitionOptions& options) {
  check(surface, options);
  if (options.proxies || options.bound) return std::nullopt;
  const double detail =
      options.tolerance ? *options.tolerance / surface_size(surface.mesh()) : options.detail.value_or(kDefaultDetail);
  return DetailSettings{finest_for(detail), options.noise, options.leave_out};
}

Partition partition(const Surface& surface, const DetailTree& tree, const PartitionOptions& options, Job& job) {
  const Threads threads(options.threads);
  const double tolerance = options.tolerance.value_or(options.detail.value_or(kDefaultDetail) * tree.size());
  const Cut cut = tree.choose(tolerance, options.snap);
  const Regions regions = tree.regions(surface, cut, threads, job);
  Partition result;
  if (options.method == Method::hierarchy) {
    result = make_partition(surface, tree.parts(), regions, {regions.error()}, threads, job);
    result.proxies_asked = result.region_count();
  } else {
    PartitionOptions counted = options;
    counted.detail = counted.tolerance = std::nullopt;
    counted.proxies = regions.count();
    result = partition(surface, Hierarchy{}, counted, job);
  }
  result.tolerance = tolerance;
  result.noise = tree.noise();
  result.snapped = cut.snapped;
  return result;
}

Partition partition_from(const Surface& surface, std::span<const std::int32_t> face_region, Job& job) {
  const FaceGraph& graph = surface.graph();
  if (face_region.size() != static_cast<std::size_t>(graph.size()))
    throw InvalidInput("there are " + std::to_string(face_region.size()) + " labels, but the mesh has " +
                       std::to_string(graph.size()) + " faces: give one for each");
  Regions regions;
  regions.label.assign(graph.faces.size(), kNone);
  std::vector<std::int32_t> stack;
  std::int32_t count = 0;
  for (std::int32_t f = 0; f < graph.size(); ++f) {
    if ((f & 0xffff) == 0) job.poll();
    const std::int32_t region = face_region[f];
    if (region < kNone)
      throw InvalidInput("the label of face " + std::to_string(f) + " is " + std::to_string(region) +
                         "; labels are at least 0, or -1 for a face in no region");
    if (region == kNone || regions.label[graph.graph_face[f]] != kNone) continue;
    regions.label[graph.graph_face[f]] = count;
    stack.push_back(graph.graph_face[f]);
    while (!stack.empty()) {
      const std::int32_t i = stack.back();
      stack.pop_back();
      for (const std::int32_t j : graph.neighbours[i]) {
        if (j == graph.size() || regions.label[j] != kNone || face_region[graph.mesh_face[j]] != region) continue;
        regions.label[j] = count;
        stack.push_back(j);
      }
    }
    ++count;
  }
  if (count == 0) throw InvalidInput("no face is in a region");
  regions.sum.resize(static_cast<std::size_t>(count));
  sum_regions(graph, regions, job);
  Parts parts = find_parts(surface, 1, 0.0, job);
  parts.asked = count;
  return make_partition(surface, parts, regions, {regions.error()}, Threads(1), job);
}

}  // namespace isimp
