#include "kept_mesh.h"

namespace isimp::bindings {

KeptMesh::Kept KeptMesh::recall(Guides guides) const {
  const std::lock_guard lock(mutex_);
  const bool same = kept_.guides.weights == guides.weights && kept_.guides.barriers == guides.barriers;
  return {std::move(guides), same ? kept_.graph : nullptr, same ? kept_.hierarchy : nullptr};
}

void KeptMesh::keep(const Kept& kept) const {
  const std::lock_guard lock(mutex_);
  kept_ = kept;
}

Partition KeptMesh::split(const PartitionOptions& options, Guides guides, Job& job) const {
  const bool guided = !guides.weights.empty() || !guides.barriers.empty();
  Kept kept = recall(std::move(guides));
  const Surface surface = guided && !kept.graph ? Surface(*this, kept.guides, job) : Surface(*this, kept.graph);
  kept.graph = surface.guided();

  const bool uses_hierarchy = options.method == Method::hierarchy || options.seeding == Seeding::hierarchical;
  const bool in_range = options.proxies >= 1 && options.proxies <= face_count();
  if (!uses_hierarchy || !in_range || job.cancelled()) return partition(surface, options, job);
  double done = 0.0;
  if (!kept.hierarchy || !kept.hierarchy->serves(surface, options.proxies)) {
    done = 0.4;
    const Job::Part stage(job, "merging", 0.0, done);
    kept.hierarchy = std::make_shared<const Hierarchy>(build_hierarchy(surface, options.proxies, job));
    keep(kept);
  }
  const Job::Part stage(job, "relaxing", done, 1.0);
  return partition(surface, *kept.hierarchy, options, job);
}

}  // namespace isimp::bindings
