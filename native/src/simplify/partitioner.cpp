#include "isimp/simplify/partitioner.h"

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "check_options.h"
#include "density/reweighted.h"
#include "hierarchy/detail_tree.h"
#include "hierarchy/hierarchy.h"
#include "inherited.h"
#include "isimp/core/errors.h"
#include "isimp/hybrid/hybrid.h"
#include "kept_flooder.h"
#include "methods.h"

namespace isimp {

struct Partitioner::Kept {
  Guides guides;
  std::shared_ptr<const GuidedGraph> graph;  // null without guides
  double adaptivity = 0.0;
  std::shared_ptr<const GuidedGraph> reweighted;  // that graph with this adaptivity; null without
  std::shared_ptr<const Hierarchy> hierarchy;
  std::shared_ptr<const DetailTree> tree;
  std::shared_ptr<const Decimated> decimated;
};

Partitioner::Partitioner(const Mesh& mesh) : Partitioner(mesh, Keep::what_helps) {}

Partitioner::Partitioner(const Mesh& mesh, Keep keep)
    : mesh_(&mesh), keep_(keep), kept_(std::make_unique<Kept>()), flooder_(std::make_unique<KeptFlooder>()) {}

Partitioner::~Partitioner() = default;

/// What is kept, if it was made under the same guides and adaptivity; else only these, and what does not depend on
/// them.
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

Partition Partitioner::run(const PartitionOptions& options, Guides guides, Job& job) const {
  const bool guided = !guides.weights.empty() || !guides.barriers.empty();
  Kept kept = recall(std::move(guides), options.adaptivity);
  const std::shared_ptr<const GuidedGraph> recalled = kept.graph;
  const Surface surface = guided && !kept.graph ? Surface(*mesh_, kept.guides, job) : Surface(*mesh_, kept.graph);
  kept.graph = surface.guided();
  if (kept.graph != recalled) keep(kept);
  return on_surface(surface, std::move(kept), options, job);
}

Partition partition(const Surface& surface, const PartitionOptions& options, Job& job) {
  return Partitioner(surface.mesh(), Partitioner::Keep::nothing).on_surface(surface, {}, options, job);
}

Partition Partitioner::on_surface(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const {
  check(surface, options);
  const bool finer = options.adaptivity > 0;
  double done = 0.0;
  if (finer && !kept.reweighted) {
    done = options.proxies ? 0.7 : 0.4;
    const Job::Part stage(job, "finding details", 0.0, done);
    kept.reweighted = reweighted(surface, options, job).guided();
    keep(kept);
  }
  const Job::Part stage(job, "partitioning", done, 1.0);
  if (!finer) return with_weights(surface, std::move(kept), options, job);
  const Surface weighted(surface.mesh(), kept.reweighted);
  return on_original_weights(surface, with_weights(weighted, std::move(kept), options, job), options, job);
}

/// On a surface whose areas are as they shall be: `options.adaptivity` is in them.
Partition Partitioner::with_weights(const Surface& surface, Kept kept, const PartitionOptions& options,
                                    Job& job) const {
  job.poll();  // where all is kept, little is polled below
  if (options.bound) return by_bound(surface, options, job);
  if (options.proxies) return by_known_number(surface, std::move(kept), options, job);
  return found_by_detail(surface, std::move(kept), options, job);
}

Partition Partitioner::found_by_detail(const Surface& surface, Kept kept, const PartitionOptions& options,
                                       Job& job) const {
  const DetailSettings settings = detail_settings(surface, options);
  double done = 0.0;
  if (!kept.tree || kept.tree->settings() != settings) {
    done = 0.8;
    const Job::Part stage(job, "merging", 0.0, done);
    kept.tree = std::make_shared<const DetailTree>(surface, settings, job);
    keep(kept);
  }
  const Job::Part stage(job, "relaxing", done, 1.0);
  Partition found = by_detail(surface, *kept.tree, options, job);
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
  if (options.method == Method::hybrid) return on_decimated(surface, std::move(kept), options, job);
  const std::int32_t proxies = *options.proxies;
  double done = 0.0;
  if (needs_hierarchy(options) && (!kept.hierarchy || !kept.hierarchy->serves(surface, proxies))) {
    done = 0.4;
    const Job::Part stage(job, "merging", 0.0, done);
    const std::int64_t coarsest = keep_ == Keep::nothing ? nodes_for(proxies) : 0;
    kept.hierarchy =
        std::make_shared<const Hierarchy>(build_hierarchy(surface, proxies, job, options.threads, coarsest));
    keep(kept);
  }
  const Job::Part stage(job, "relaxing", done, 1.0);
  const Hierarchy none;
  const Hierarchy& hierarchy = needs_hierarchy(options) ? *kept.hierarchy : none;
  if (!needs_flooder(options)) return by_number(surface, hierarchy, nullptr, options, job);
  return flooder_->with(surface, options.backend, [&](parallel::Flooder& flooder) {
    return by_number(surface, hierarchy, &flooder, options, job);
  });
}

Partition Partitioner::on_decimated(const Surface& surface, Kept kept, const PartitionOptions& options,
                                    Job& job) const {
  double done = 0.0;
  if (!kept.decimated || kept.decimated->fraction != options.fraction) {
    done = 0.9;
    const Job::Part stage(job, "decimating", 0.0, done);
    kept.decimated = std::make_shared<const Decimated>(decimate(surface, options.fraction, job));
    keep(kept);
  }
  const Job::Part stage(job, "partitioning", done, 1.0);
  return hybrid(surface, *kept.decimated, options, job);
}

}  // namespace isimp
