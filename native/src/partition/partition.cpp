// Cohen-Steiner, Alliez, Desbrun: Variational Shape Approximation, 2004.

#include "isimp/partition/partition.h"

#include <sstream>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/parallel/backend.h"
#include "isimp/partition/hierarchy.h"
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
  if (given.find(' ') != std::string::npos)
    throw InvalidInput(given + " are given, but each alone says how many regions there will be: give one of them");
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (options.proxies && (*options.proxies < 1 || *options.proxies > surface.face_count()))
    out_of_range("proxies", "in [1, " + std::to_string(surface.face_count()) + "]", *options.proxies);
  if (options.detail && !(*options.detail > 0 && *options.detail <= 1))
    out_of_range("detail", "in (0, 1]", *options.detail);
  if (options.tolerance && !positive(*options.tolerance))
    out_of_range("tolerance", "a finite length above 0", *options.tolerance);
  if (options.noise && !positive(*options.noise) && *options.noise != 0)
    out_of_range("noise", "a finite length, at least 0", *options.noise);
}

void check(const Surface& surface, const PartitionOptions& options) {
  check_count(surface, options);
  if (!(options.leave_out >= 0 && options.leave_out < 1)) out_of_range("leave_out", "in [0, 1)", options.leave_out);
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
  Relaxation<GraphLabels> relaxation(graph, {regions.label.data()}, regions.sum, border_weight(regions.error()));
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
    for (std::int32_t i = begin; i < end; ++i) result.face_region[graph.mesh_face[i]] = regions.label[i];
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

Partition partition(const Surface& surface, const PartitionOptions& options, Job& job) {
  return partition(surface, Hierarchy{}, options, job);
}

Partition partition(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options, Job& job,
                    parallel::Flooder* flooder) {
  const std::optional<DetailSettings> settings = detail_settings(surface, options);
  if (options.method == Method::hybrid) throw InvalidInput("method hybrid is for hybrid(), which decimates first");
  Job::Part stage(job, "partitioning", 0.0, 1.0);
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
    own = build_hierarchy(surface, proxies, job, options.threads);
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
  if (options.proxies) return std::nullopt;
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
    result = partition(surface, counted, job);
  }
  result.tolerance = tolerance;
  result.noise = tree.noise();
  result.snapped = cut.snapped;
  return result;
}

}  // namespace isimp
