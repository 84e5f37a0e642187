#include "isimp/simplify/partitioner.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "components.h"
#include "hierarchy/detail_tree.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/curved/round.h"
#include "isimp/mesh/part_of.h"
#include "isimp/partition/keep_regions.h"
#include "isimp/partition/noise.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/soundness.h"
#include "isimp/simplify/edges.h"
#include "isimp/simplify/openings.h"
#include "isimp/thesis/thesis.h"
#include "make_partition.h"
#include "methods.h"
#include "sharp_edges.h"

namespace isimp {
namespace {

constexpr int kMoreRounds = 2;  // limit: partitions whose strips join until a given number of regions is left

}  // namespace

struct Partitioner::Kept {
  Guides guides;
  std::shared_ptr<const GuidedGraph> graph;  // null without guides
  double adaptivity = 0.0;
  std::shared_ptr<const GuidedGraph> reweighted;  // that graph with this adaptivity; null without
  std::shared_ptr<const Hierarchy> hierarchy;
  std::shared_ptr<const DetailTree> tree;
};

/// A surface, and the data that is kept for it.
struct Partitioner::Prepared {
  Surface surface;
  Kept kept;
};

/// Some faces of the mesh as a mesh of their own, with the kept data of its partitions.
struct Partitioner::Submesh {
  Submesh(const Mesh& whole, std::span<const std::int32_t> faces, Job& job)
      : open(faces.begin(), faces.end()), mesh(part_of(whole, faces, job)), partitioner(mesh) {}
  std::vector<std::int32_t> open;
  Mesh mesh;
  Partitioner partitioner;
};

Partitioner::Partitioner(const Mesh& mesh) : Partitioner(mesh, Keep::what_helps) {}

Partitioner::Partitioner(const Mesh& mesh, Keep keep)
    : mesh_(&mesh), keep_(keep), kept_(std::make_unique<Kept>()), thesis_(std::make_unique<Thesis>()) {}

Partitioner::~Partitioner() = default;

std::int32_t proxies_for(std::int32_t triangles, std::int32_t faces) {
  // tuned expected
  constexpr double kTriangles = 3.5;  // mean number of triangles of a polygon
  return std::clamp(static_cast<std::int32_t>(std::lround(triangles / kTriangles)), 1, faces);
}

/// Returns the kept data if its guides and adaptivity are the same. Otherwise returns the given ones, with that part of
/// the kept data that does not depend on them.
Partitioner::Kept Partitioner::recall(Guides guides, double adaptivity) const {
  const std::lock_guard lock(mutex_);
  const bool same = kept_->guides.weights == guides.weights && kept_->guides.barriers == guides.barriers;
  if (same && kept_->adaptivity == adaptivity) return *kept_;
  Kept fresh;
  fresh.graph = same ? kept_->graph : nullptr;
  fresh.guides = std::move(guides);
  fresh.adaptivity = adaptivity;
  return fresh;
}

void Partitioner::keep(const Kept& kept) const {
  if (keep_ == Keep::nothing) return;
  const std::lock_guard lock(mutex_);
  *kept_ = kept;
}

Partitioner::Prepared Partitioner::prepare(Guides guides, double adaptivity, Job& job) const {
  const bool guided = !guides.weights.empty() || !guides.barriers.empty();
  Kept kept = recall(std::move(guides), adaptivity);
  const std::shared_ptr<const GuidedGraph> recalled = kept.graph;
  const Surface surface = guided && !kept.graph ? Surface(*mesh_, kept.guides, job) : Surface(*mesh_, kept.graph);
  kept.graph = surface.guided();
  if (kept.graph != recalled) keep(kept);
  return {surface, std::move(kept)};
}

Partition Partitioner::run(const PartitionOptions& options, const Constraints& given, Job& job) const {
  if (options.triangles) {
    check(*mesh_, options);
    PartitionOptions counted = options;
    counted.triangles.reset();
    counted.proxies = proxies_for(*options.triangles, mesh_->face_count());
    return run(counted, given, job);
  }
  if (given.before == nullptr && !given.faces && options.leave_out > 0 && mesh_->component_count() > 1) {
    check(*mesh_, options);
    const Components components = find_components(*mesh_, options.proxies.value_or(1), options.leave_out, job);
    if (components.left_out > 0) return on_kept(components, options, given, job);
  }
  return with_all_components(options, given, job);
}

Partition Partitioner::with_all_components(const PartitionOptions& options, const Constraints& given, Job& job) const {
  Constraints constraints = given;
  if (options.proxies)
    constraints.guides.weights =
        weights_without_patches(*mesh_, mesh_->source_face(), given.guides.weights, *options.proxies);
  Partition result =
      options.curved ? with_round_parts(options, constraints, job) : by_planes(options, constraints, job);
  const bool whole = constraints.before == nullptr && !constraints.faces;
  // Round parts begin with a partition by planes, whose edges are sharp already.
  std::optional<double> sharp_edges = options.sharp_edges;
  if (!sharp_edges && options.snap && result.tolerance > 0 && is_of_planes(*mesh_, result)) sharp_edges = 0.0;
  if (sharp_edges && !options.curved && whole && !options.bound)
    result = with_sharp_edges(result, *sharp_edges, options, constraints, job);
  ISIMP_ASSERT(broken_promise(Surface(*mesh_, result.guided), result).empty(), "a partition keeps its promises");
  return result;
}

/// Joins strips of edges with the adjacent planes. Where the number of regions is given, as many more are made first as
/// join, so that this number is left: the second time the widest strips stay for it.
Partition Partitioner::with_sharp_edges(const Partition& part, double width, const PartitionOptions& options,
                                        const Constraints& constraints, Job& job) const {
  const auto sharpened = [&](const Partition& of, std::int32_t least) {
    const auto labels = without_strips(*mesh_, of, width, least, job);
    return labels ? inherited(partition_from(Surface(*mesh_, of.guided), *labels, job), of) : of;
  };
  const std::int32_t asked = part.region_count();
  Partition sharp = sharpened(part, 1);
  std::int32_t joined = asked - sharp.region_count();
  PartitionOptions more = options;
  for (int round = 0; options.proxies && round < kMoreRounds && sharp.region_count() < asked; ++round) {
    more.proxies = std::min(asked + joined, mesh_->face_count());
    const Partition finer = by_planes(more, constraints, job);
    Partition next = sharpened(finer, round + 1 < kMoreRounds ? 1 : asked);
    joined = finer.region_count() - next.region_count();
    if (next.region_count() <= asked) sharp = std::move(next);
  }
  sharp.proxies_asked = std::min(part.proxies_asked, sharp.region_count());
  return sharp;
}

Partition Partitioner::with_round_parts(const PartitionOptions& options, const Constraints& constraints,
                                        Job& job) const {
  if (options.bound) throw InvalidInput("round parts can't be had with a bound: leave out one of the two");
  PartitionOptions plain = options;
  plain.curved = false;
  Partition part = [&] {
    const Job::Stage stage(job, "partitioning", 0.0, 0.6);
    return run(plain, constraints, job);
  }();
  Prepared prepared = prepare(constraints.with_cuts(), options.adaptivity, job);
  const Surface surface = prepared.surface;
  const std::vector<std::int32_t> small = [&] {
    const Job::Stage stage(job, "partitioning", 0.6, 0.8);
    const bool has_tree =
        !options.proxies && options.adaptivity == 0 && !open_faces(*mesh_, constraints, 1, options.leave_out, job);
    return small_regions(surface, std::move(prepared.kept), options, has_tree, job);
  }();
  const Job::Stage stage(job, "finding round parts", 0.8, 1.0);
  const bool is_found = part.tolerance > 0;
  const RoundLengths lengths{.tolerance = is_found ? part.tolerance : kDefaultDetail * surface_size(*mesh_),
                             .noise = is_found        ? part.noise
                                      : options.noise ? *options.noise
                                                      : estimate_noise(*mesh_, Threads(options.threads), job)};
  std::vector<std::uint8_t> stays;
  if (constraints.faces) {
    stays.assign(static_cast<std::size_t>(mesh_->face_count()), 1);
    for (const std::int32_t f : *constraints.faces) stays[f] = 0;
  }
  return round_parts(surface, std::move(part), small, lengths, stays, job);
}

/// The small regions in which round parts are found: from the tree that the partition was cut from where it is of the
/// whole surface, else of a partition of their own. Which of the two does not depend on what is kept.
std::vector<std::int32_t> Partitioner::small_regions(const Surface& surface, Kept kept, const PartitionOptions& options,
                                                     bool has_tree, Job& job) const {
  if (has_tree) return detail_tree(surface, kept, options, job)->small_regions(surface);
  PartitionOptions small;
  small.proxies = small_count(mesh_->face_count());
  small.leave_out = 0.0;
  small.metric = Metric::normals;
  small.threads = options.threads;
  const Partition data = by_known_number(surface, std::move(kept), small, job);
  return {data.face_region.begin(), data.face_region.end()};
}

Partition Partitioner::by_planes(const PartitionOptions& options, const Constraints& constraints, Job& job) const {
  const auto open = open_faces(*mesh_, constraints, options.proxies.value_or(1), options.leave_out, job);
  Prepared prepared = prepare(constraints.with_cuts(), options.adaptivity, job);
  const Surface& surface = prepared.surface;
  const auto split = [&] {
    if (open) return on_part(surface, *open, options, constraints, job);
    return on_surface(surface, std::move(prepared.kept), options, job);
  };
  if (constraints.cuts.empty()) return split();
  Partition result;
  {
    const Job::Stage stage(job, "partitioning", 0.0, 0.9);
    result = split();
  }
  const Job::Stage stage(job, "cutting", 0.9, 1.0);
  const auto labels = parted_at(*mesh_, result, constraints.cuts, job);
  if (!labels) return result;
  Partition parted = inherited(partition_from(surface, *labels, job), result);
  if (parted.bound > 0) restate_error(surface.graph(), parted);
  return parted;
}

Partition partition(const Surface& surface, const PartitionOptions& options, Job& job) {
  Partition result = Partitioner(surface.mesh(), Partitioner::Keep::nothing).on_surface(surface, {}, options, job);
  ISIMP_ASSERT(broken_promise(surface, result).empty(), "a partition keeps its promises");
  return result;
}

Partition Partitioner::on_surface(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const {
  check(surface, options);
  Thesis::check(options);
  const bool finer = options.adaptivity > 0;
  double done = 0.0;
  if (finer && !kept.reweighted) {
    done = options.proxies ? 0.7 : 0.4;
    const Job::Stage stage(job, "finding details", 0.0, done);
    kept.reweighted = reweighted(surface, options, job).guided();
    keep(kept);
  }
  const Job::Stage stage(job, "partitioning", done, 1.0);
  if (!finer) return with_weights(surface, std::move(kept), options, job);
  const Surface weighted(surface.mesh(), kept.reweighted);
  return on_original_weights(surface, with_weights(weighted, std::move(kept), options, job), options, job);
}

std::shared_ptr<const Partitioner::Submesh> Partitioner::submesh(std::span<const std::int32_t> open, Job& job) const {
  {
    const std::lock_guard lock(mutex_);
    if (submesh_ && std::ranges::equal(submesh_->open, open)) return submesh_;
  }
  auto part = std::make_shared<const Submesh>(*mesh_, open, job);
  const std::lock_guard lock(mutex_);
  if (keep_ != Keep::nothing) submesh_ = part;
  return part;
}

namespace {

/// The face of the whole mesh for each face of a part.
std::vector<std::int32_t> whole_faces(const Mesh& part, std::span<const std::int32_t> open) {
  std::vector<std::int32_t> face;
  face.reserve(open.size());
  for (const std::int32_t f : part.source_face()) face.push_back(open[f]);
  return face;
}

Guides guides_of_part(const Guides& whole, const Mesh& part, std::span<const std::int32_t> face, Job& job) {
  Guides guides;
  if (!whole.weights.empty())
    for (const std::int32_t f : face) guides.weights.push_back(whole.weights[f]);
  guides.barriers = marked_edges(part, whole.barriers, job);
  return guides;
}

/// The sums of the faces of each region.
std::vector<RegionSum> sums_of(const FaceGraph& graph, const Partition& partition, Job& job) {
  Regions regions;
  regions.label.assign(graph.faces.size(), kNone);
  for (std::int32_t i = 0; i < graph.size(); ++i) regions.label[i] = partition.face_region[graph.mesh_face[i]];
  regions.sum.resize(partition.region_seed.size());
  sum_regions(graph, regions, job);
  return std::move(regions.sum);
}

/// No component is left out. Locked regions count in the requested number, unless they are left out.
PartitionOptions options_of_part(PartitionOptions options, const Constraints& constraints) {
  options.leave_out = 0.0;
  if (constraints.faces || !options.proxies) return options;
  const auto& locked = constraints.before->region_locked;
  const auto count = std::ranges::count(locked, kLocked);
  options.proxies = std::max(1, *options.proxies - static_cast<std::int32_t>(count));
  return options;
}

/// (F) The labels that stay: labels of locked regions and, where only some faces are split, of all other faces.
std::vector<std::int32_t> labels_that_stay(const Constraints& constraints, std::int32_t face_count) {
  std::vector<std::int32_t> labels(static_cast<std::size_t>(face_count), kNone);
  if (constraints.before == nullptr) return labels;
  const Partition& before = *constraints.before;
  for (std::size_t f = 0; f < labels.size(); ++f) {
    const std::int32_t region = before.face_region[f];
    if (region != kNone && (constraints.faces || before.region_locked[region] != 0)) labels[f] = region;
  }
  return labels;
}

/// Locks the regions that lie in locked ones.
void lock_as(Partition& part, const Partition& before) {
  if (before.region_locked.empty()) return;
  for (const std::int32_t seed : part.region_seed) {
    const std::int32_t region = before.face_region[seed];
    part.region_locked.push_back(region == kNone ? 0 : before.region_locked[region]);
  }
  if (std::ranges::count(part.region_locked, 0) == part.region_count()) part.region_locked.clear();
}

/// Holds the planes of the regions that have not changed.
void hold_as(Partition& part, const Partition& before, bool all_stay) {
  if (before.region_held.empty()) return;
  part.region_offset.resize(part.region_seed.size());
  part.region_held.assign(part.region_seed.size(), 0);
  if (!before.region_cell.empty()) part.region_cell.resize(part.region_seed.size());
  part.curved = before.curved;
  for (std::size_t r = 0; r < part.region_seed.size(); ++r) {
    const std::int32_t region = before.face_region[part.region_seed[r]];
    const bool is_locked = region != kNone && !before.region_locked.empty() && before.region_locked[region] != 0;
    if (region == kNone || !(all_stay || is_locked)) continue;
    if (part.region_sum[r].faces != before.region_sum[region].faces) continue;  // some of its faces were split off
    part.region_held[r] = before.region_held[region];
    if (!before.region_cell.empty()) part.region_cell[r] = before.region_cell[region];
    if (!before.is_held(region)) continue;
    part.region_normal[r] = before.region_normal[region];
    part.region_offset[r] = before.region_offset[region];
  }
}

}  // namespace

/// On the components that are kept, as a mesh of their own.
Partition Partitioner::on_kept(const Components& components, const PartitionOptions& options,
                               const Constraints& constraints, Job& job) const {
  std::vector<std::int32_t> kept;
  for (std::int32_t f = 0; f < mesh_->face_count(); ++f)
    if (components.all[mesh_->component()[f]].kept) kept.push_back(f);
  const std::shared_ptr<const Submesh> own = [&] {
    const Job::Stage stage(job, "cutting off a part", 0.0, 0.1);
    return submesh(kept, job);
  }();
  Constraints inner{.guides = guides_of_part(constraints.guides, own->mesh, kept, job),
                    .cuts = marked_edges(own->mesh, constraints.cuts, job)};
  if (options.proxies) {
    std::vector<std::int32_t> source;  // the part's own names faces of the mesh
    source.reserve(kept.size());
    for (const std::int32_t f : kept) source.push_back(mesh_->source_face()[f]);
    inner.guides.weights =
        weights_without_patches(own->mesh, source, std::move(inner.guides.weights), *options.proxies);
  }
  PartitionOptions all = options;
  all.leave_out = 0.0;
  Partition result = [&] {
    const Job::Stage stage(job, "partitioning", 0.1, 1.0);
    return own->partitioner.with_all_components(all, inner, job);
  }();

  Guides guides = constraints.with_cuts();
  if (!inner.guides.weights.empty()) {
    guides.weights.resize(static_cast<std::size_t>(mesh_->face_count()), 1.0);
    for (std::size_t k = 0; k < kept.size(); ++k) guides.weights[kept[k]] = inner.guides.weights[k];
  }
  const Surface surface = prepare(std::move(guides), options.adaptivity, job).surface;
  to_whole_faces(result, kept, static_cast<std::size_t>(mesh_->face_count()));
  result.region_sum = sums_of(surface.graph(), result, job);
  result.guided = surface.guided();
  result.parts_left_out = components.left_out;
  result.area_left_out = components.area_left_out;
  ISIMP_ASSERT(broken_promise(surface, result).empty(), "a partition keeps its promises");
  return result;
}

Partition Partitioner::on_part(const Surface& surface, std::span<const std::int32_t> open,
                               const PartitionOptions& options, const Constraints& constraints, Job& job) const {
  check(surface, options);
  Thesis::check(options);
  const std::shared_ptr<const Submesh> part = [&] {
    const Job::Stage stage(job, "cutting off a part", 0.0, 0.1);
    return submesh(open, job);
  }();
  const std::vector<std::int32_t> face = whole_faces(part->mesh, open);
  ISIMP_ASSERT(face.size() == open.size(), "a part has all faces that are split");
  const Constraints inner{.guides = guides_of_part(constraints.with_cuts(), part->mesh, face, job)};
  const Partition split = [&] {
    const Job::Stage stage(job, "partitioning", 0.1, 0.95);
    return part->partitioner.run(options_of_part(options, constraints), inner, job);
  }();
  std::vector<std::int32_t> labels = labels_that_stay(constraints, mesh_->face_count());
  const std::int32_t first = *std::ranges::max_element(labels) + 1;
  for (std::size_t k = 0; k < face.size(); ++k) labels[face[k]] = first + split.face_region[k];
  Partition result = partition_from(surface, labels, job);
  if (constraints.before == nullptr) {
    take_how_found(result, split);
    return result;
  }
  lock_as(result, *constraints.before);
  hold_as(result, *constraints.before, constraints.faces.has_value());
  return result;
}

/// On a surface with final areas: they include `options.adaptivity`.
Partition Partitioner::with_weights(const Surface& surface, Kept kept, const PartitionOptions& options,
                                    Job& job) const {
  job.poll();  // if all is kept, little is polled below
  if (options.bound) return by_bound(surface, options, job);
  if (options.proxies) return by_known_number(surface, std::move(kept), options, job);
  return found_by_detail(surface, std::move(kept), options, job);
}

/// The tree from which a number of regions is found: the kept one, or a new one, which is kept.
std::shared_ptr<const DetailTree> Partitioner::detail_tree(const Surface& surface, Kept& kept,
                                                           const PartitionOptions& options, Job& job) const {
  const DetailSettings settings = detail_settings(surface, options);
  if (!kept.tree || kept.tree->settings() != settings) {
    const Job::Stage stage(job, "merging", 0.0, 0.8);
    kept.tree = std::make_shared<const DetailTree>(surface, settings, job, options.threads);
    keep(kept);
  }
  return kept.tree;
}

Partition Partitioner::found_by_detail(const Surface& surface, Kept kept, const PartitionOptions& options,
                                       Job& job) const {
  const auto tree = detail_tree(surface, kept, options, job);
  const Job::Stage stage(job, "relaxing", 0.8, 1.0);
  Partition found = by_detail(surface, *tree, options, job);
  if (options.method == Method::hierarchy) return found;
  PartitionOptions counted = options;
  counted.proxies = found.region_count();
  counted.detail = counted.tolerance = std::nullopt;
  Partition result = by_known_number(surface, std::move(kept), counted, job);
  take_how_found(result, found);
  return result;
}

Partition Partitioner::by_known_number(const Surface& surface, Kept kept, const PartitionOptions& options,
                                       Job& job) const {
  const std::int32_t proxies = *options.proxies;
  double done = 0.0;
  if (needs_hierarchy(options) && (!kept.hierarchy || !kept.hierarchy->serves(surface, proxies))) {
    done = 0.4;
    const Job::Stage stage(job, "merging", 0.0, done);
    const std::int64_t coarsest = keep_ == Keep::nothing ? nodes_for(proxies) : 0;
    kept.hierarchy = std::make_shared<const Hierarchy>(
        build_hierarchy(surface, proxies, job, {.threads = options.threads, .coarsest = coarsest}));
    keep(kept);
  }
  const Job::Stage stage(job, "relaxing", done, 1.0);
  const Hierarchy none;
  const Hierarchy& hierarchy = needs_hierarchy(options) ? *kept.hierarchy : none;
  if (options.method == Method::hierarchy) return by_number(surface, hierarchy, options, job);
  return thesis_->by_number(surface, hierarchy, options, job);
}

}  // namespace isimp
