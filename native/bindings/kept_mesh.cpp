#include "kept_mesh.h"

#include "isimp/partition/parallel_lloyd.h"

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

KeptMesh::Loaded KeptMesh::borrow(const Surface& surface, const std::string& backend) const {
  {
    const std::lock_guard lock(mutex_);
    if (loaded_.flooder && loaded_.backend == backend && loaded_.graph == surface.guided())
      return std::exchange(loaded_, {});
  }
  return {backend, surface.guided(), load(surface, backend)};
}

void KeptMesh::give_back(Loaded loaded) const {
  const std::lock_guard lock(mutex_);
  loaded_ = std::move(loaded);
}

Partition KeptMesh::split(const PartitionOptions& options, Guides guides, Job& job) const {
  const bool guided = !guides.weights.empty() || !guides.barriers.empty();
  Kept kept = recall(std::move(guides));
  const std::shared_ptr<const GuidedGraph> recalled = kept.graph;
  const Surface surface = guided && !kept.graph ? Surface(*this, kept.guides, job) : Surface(*this, kept.graph);
  kept.graph = surface.guided();

  const bool parallel = options.method == Method::naive || options.method == Method::queued;
  const bool uses_hierarchy = options.method == Method::hierarchy || options.seeding == Seeding::hierarchical;
  const bool in_range = options.proxies >= 1 && options.proxies <= face_count();
  if ((!uses_hierarchy && !parallel) || !in_range || job.cancelled()) return partition(surface, options, job);
  bool made = guided && kept.graph != recalled;
  double done = 0.0;
  if (uses_hierarchy && (!kept.hierarchy || !kept.hierarchy->serves(surface, options.proxies))) {
    done = 0.4;
    const Job::Part stage(job, "merging", 0.0, done);
    kept.hierarchy = std::make_shared<const Hierarchy>(build_hierarchy(surface, options.proxies, job));
    made = true;
  }
  if (made) keep(kept);
  const Job::Part stage(job, "relaxing", done, 1.0);
  if (!parallel) return partition(surface, *kept.hierarchy, options, job);
  Loaded loaded = borrow(surface, options.backend);
  Partition result =
      partition(surface, kept.hierarchy ? *kept.hierarchy : Hierarchy{}, options, job, loaded.flooder.get());
  give_back(std::move(loaded));
  return result;
}

}  // namespace isimp::bindings
