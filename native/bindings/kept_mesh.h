#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "isimp/hybrid/hybrid.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/hierarchy.h"
#include "isimp/partition/kept_flooder.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp::bindings {

/// A mesh as Python holds it: with what its last partitions left that makes another number of regions quick.
class KeptMesh : public Mesh {
 public:
  explicit KeptMesh(Mesh&& mesh) : Mesh(std::move(mesh)) {}

  /// Partitions this mesh, guided or not. What the last call made and the next one can use is kept: the guided graph,
  /// the tree that finds the number of regions, and the hierarchy, the decimated mesh or a device's memory where the
  /// method has one. May be called from several threads.
  [[nodiscard]] Partition split(const PartitionOptions& options, Guides guides, Job& job) const;
  /// (V) in the caller's coordinates; made when first asked for where these are not the mesh's own.
  [[nodiscard]] std::span<const Vec3> placed_vertices() const;

 private:
  struct Kept {
    Guides guides;
    std::shared_ptr<const GuidedGraph> graph;  // null without guides
    double adaptivity = 0.0;
    std::shared_ptr<const GuidedGraph> adapted;  // that graph with this adaptivity; null without
    std::shared_ptr<const Hierarchy> hierarchy;
    std::shared_ptr<const DetailTree> tree;
    std::shared_ptr<const Decimated> decimated;
  };
  /// These guides and adaptivity, with what is kept if it was made under the same.
  [[nodiscard]] Kept recall(Guides guides, double adaptivity) const;
  Partition split(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;
  void keep(const Kept& kept) const;
  Partition split_by_detail(const Surface& surface, Kept kept, const DetailSettings& settings,
                            const PartitionOptions& options, Job& job) const;
  Partition split_by_count(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;
  Partition split_decimated(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;

  mutable std::mutex mutex_;
  mutable Kept kept_;
  mutable std::once_flag once_placed_;
  mutable std::vector<Vec3> placed_;  // empty where `origin` is zero
  KeptFlooder flooder_;
};

}  // namespace isimp::bindings
