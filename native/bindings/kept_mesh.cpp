#include "kept_mesh.h"

namespace isimp::bindings {

std::span<const Vec3> KeptMesh::placed_vertices() const {
  if (origin().isZero(0)) return vertices();
  std::call_once(once_placed_, [&] {
    placed_.assign(vertices().begin(), vertices().end());
    for (Vec3& v : placed_) v += origin();
  });
  return placed_;
}

KeptMesh::Kept KeptMesh::recall(Guides guides, double adaptivity) const {
  const std::lock_guard lock(mutex_);
  const bool same = kept_.guides.weights == guides.weights && kept_.guides.barriers == guides.barriers;
  if (same && kept_.adaptivity == adaptivity) return kept_;
  Kept fresh;
  fresh.graph = same ? kept_.graph : nullptr;
  fresh.guides = std::move(guides);
  fresh.adaptivity = adaptivity;
  return fresh;
}

void KeptMesh::keep(const Kept& kept) const {
  const std::lock_guard lock(mutex_);
  kept_ = kept;
}

Partition KeptMesh::split(const PartitionOptions& options, Guides guides, Job& job) const {
  const bool guided = !guides.weights.empty() || !guides.barriers.empty();
  Kept kept = recall(std::move(guides), options.adaptivity);
  const std::shared_ptr<const GuidedGraph> recalled = kept.graph;
  const Surface surface = guided && !kept.graph ? Surface(*this, kept.guides, job) : Surface(*this, kept.graph);
  kept.graph = surface.guided();
  if (kept.graph != recalled) keep(kept);
  if (options.adaptivity == 0) return split(surface, std::move(kept), options, job);
  double done = 0.0;
  if (!kept.adapted) {
    done = adapting_share(options);
    const Job::Part stage(job, "finding details", 0.0, done);
    kept.adapted = adapted(surface, options, job).guided();
    keep(kept);
  }
  const Job::Part stage(job, "partitioning", done, 1.0);
  const Surface finer(*this, kept.adapted);
  PartitionOptions plain = options;  // what is adapted once must not be again
  plain.adaptivity = 0;
  return restated(surface, split(finer, std::move(kept), plain, job), options, job);
}

Partition KeptMesh::split(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const {
  const std::optional<DetailSettings> settings = detail_settings(surface, options);
  if (job.cancelled() || options.bound) return partition(surface, Hierarchy{}, options, job);
  return settings ? split_by_detail(surface, std::move(kept), *settings, options, job)
                  : split_by_count(surface, std::move(kept), options, job);
}

Partition KeptMesh::split_by_detail(const Surface& surface, Kept kept, const DetailSettings& settings,
                                    const PartitionOptions& options, Job& job) const {
  double done = 0.0;
  if (!kept.tree || kept.tree->settings() != settings) {
    done = 0.8;
    const Job::Part stage(job, "merging", 0.0, done);
    kept.tree = std::make_shared<const DetailTree>(surface, settings, job);
    keep(kept);
  }
  const Job::Part stage(job, "relaxing", done, 1.0);
  if (options.method != Method::hybrid) return partition(surface, *kept.tree, options, job);
  PartitionOptions counted = options;
  counted.method = Method::hierarchy;
  const Partition found = partition(surface, *kept.tree, counted, job);
  counted.method = options.method;
  counted.proxies = found.region_count();
  counted.detail = counted.tolerance = std::nullopt;
  Partition result = split_by_count(surface, std::move(kept), counted, job);
  result.tolerance = found.tolerance;
  result.noise = found.noise;
  result.snapped = found.snapped;
  return result;
}

Partition KeptMesh::split_decimated(const Surface& surface, Kept kept, const PartitionOptions& options,
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

Partition KeptMesh::split_by_count(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const {
  const bool parallel = options.method == Method::naive || options.method == Method::queued;
  if (options.method == Method::hybrid) return split_decimated(surface, std::move(kept), options, job);
  const bool uses_hierarchy = options.method == Method::hierarchy || options.seeding == Seeding::hierarchical;
  if (!uses_hierarchy && !parallel) return partition(surface, Hierarchy{}, options, job);
  const std::int32_t proxies = *options.proxies;
  double done = 0.0;
  if (uses_hierarchy && (!kept.hierarchy || !kept.hierarchy->serves(surface, proxies))) {
    done = 0.4;
    const Job::Part stage(job, "merging", 0.0, done);
    kept.hierarchy = std::make_shared<const Hierarchy>(build_hierarchy(surface, proxies, job, options.threads));
    keep(kept);
  }
  const Job::Part stage(job, "relaxing", done, 1.0);
  if (!parallel) return partition(surface, *kept.hierarchy, options, job);
  return flooder_.with(surface, options.backend, [&](parallel::Flooder& flooder) {
    return partition(surface, kept.hierarchy ? *kept.hierarchy : Hierarchy{}, options, job, &flooder);
  });
}

}  // namespace isimp::bindings
