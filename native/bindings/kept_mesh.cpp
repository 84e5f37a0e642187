#include "kept_mesh.h"

#include "isimp/partition/hierarchy.h"

namespace isimp::bindings {

std::shared_ptr<const Hierarchy> KeptMesh::kept(std::int32_t proxies) const {
  const std::lock_guard lock(mutex_);
  return hierarchy_ && hierarchy_->serves(*this, proxies) ? hierarchy_ : nullptr;
}

Partition KeptMesh::split(const PartitionOptions& options, Job& job) const {
  const bool uses_one = options.method == Method::hierarchy || options.seeding == Seeding::hierarchical;
  const bool in_range = options.proxies >= 1 && options.proxies <= face_count();
  if (!uses_one || !in_range || job.cancelled()) return partition(*this, options, job);
  std::shared_ptr<const Hierarchy> hierarchy = kept(options.proxies);
  double done = 0.0;
  if (!hierarchy) {
    done = 0.4;
    const Job::Part stage(job, "merging", 0.0, done);
    hierarchy = std::make_shared<const Hierarchy>(build_hierarchy(*this, options.proxies, job));
    const std::lock_guard lock(mutex_);
    hierarchy_ = hierarchy;
  }
  const Job::Part stage(job, "relaxing", done, 1.0);
  return partition(*this, *hierarchy, options, job);
}

}  // namespace isimp::bindings
