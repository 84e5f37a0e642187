#pragma once

#include <memory>
#include <mutex>
#include <span>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"
#include "isimp/simplify/constraints.h"

namespace isimp {

class DetailTree;
struct Components;
struct Hierarchy;
class Thesis;

/// Makes partitions of one mesh: the only place that chooses the method, the number of regions, and the data that is
/// kept from one call to the next.
///
/// It keeps the data that another number of regions can use: the guided graph, the graph with another density, the tree
/// that finds the number of regions, the hierarchy where the method has one, and the data of Thesis; and the same for
/// the part of the mesh that was split alone. So a second call takes a fraction of the first one's time. The results
/// are those of a new Partitioner, bit for bit.
class Partitioner {
 public:
  /// \param mesh  must outlive this, at the same address
  explicit Partitioner(const Mesh& mesh);
  Partitioner(const Partitioner&) = delete;
  Partitioner& operator=(const Partitioner&) = delete;
  ~Partitioner();
  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }

  /// Splits the mesh into connected, near-planar regions.
  ///
  /// - `proxies`: exactly that many regions.
  /// - `detail` or `tolerance`: as many as the surface shows at that tolerance t, independent of its resolution. On a
  ///   curved surface the mean distance from the regions' planes is about t. t counts as at least
  ///   kNoiseDeviations (choose_cut.h) times the deviation of the noise. lloyd and teleport then make that number.
  /// - `bound`: few regions, each with all its vertices within that of one plane.
  ///
  /// No region is empty, each is connected, every face of a kept component is in one. Every kept component gets at
  /// least the number that its topology needs: 4 if it is closed, else 1; never more than its faces. If these are more
  /// than `proxies`, they are made, and `proxies_needed` is their number. Components each below `leave_out` of the area
  /// are left out, smallest first, while all of them together stay below ten times it, or below twenty times it where
  /// each has less than a tenth of the mean area of `proxies` regions. The largest is always kept, and none is left out
  /// where the rest would have fewer than `proxies` faces. The rest is partitioned as a mesh of its own, so that the
  /// result does not depend on other components.
  /// The same mesh, options and constraints give the same partition bit for bit: nothing depends on hashing, on the
  /// order of threads or on a library's random numbers. May be called from several threads at once.
  ///
  /// Constraints:
  ///  - weights multiply the areas, also for `error`; if `proxies` are given, small patches that closed openings have
  ///    none (see weights_without_patches); barriers cut the mesh, so that it may have more components;
  ///  - a region that contains the end of a cut is split (see parted_at);
  ///  - if only some faces are split, they become a mesh of their own, which is partitioned with nothing left out.
  ///    Borders to the other faces stay as they are; regions that fall apart by it become several. With locked regions
  ///    and without `faces`, `proxies` counts the locked ones too.
  ///
  /// With `curved` round parts become rings of cells; see round_parts.
  ///
  /// \param job     polled at least every 50 ms; reports progress in [0, 1]
  /// \throws InvalidInput  an option out of its range, a weight, barrier or face that can't be used: the message names
  ///                       the range and the value; open_faces() lists further errors
  /// \throws Error         a device has too little memory or failed
  /// \throws Cancelled     nothing was changed
  ///
  /// Cost: Method::hierarchy O(F), about 100 ms for a million faces; the others O(iterations * F). Finding the number
  /// O(F log F) more. O(F) memory.
  /// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.
  [[nodiscard]] Partition run(const PartitionOptions& options, const Constraints& constraints, Job& job) const;

 private:
  friend Partition partition(const Surface& surface, const PartitionOptions& options, Job& job);
  struct Kept;
  struct Submesh;
  struct Prepared;
  enum class Keep { nothing, what_helps };
  Partitioner(const Mesh& mesh, Keep keep);

  [[nodiscard]] Kept recall(Guides guides, double adaptivity) const;
  void keep(const Kept& kept) const;
  [[nodiscard]] Prepared prepare(Guides guides, double adaptivity, Job& job) const;
  [[nodiscard]] std::shared_ptr<const Submesh> submesh(std::span<const std::int32_t> open, Job& job) const;
  Partition with_sharp_edges(const Partition& part, double width, const PartitionOptions& options,
                             const Constraints& constraints, Job& job) const;
  Partition with_round_parts(const PartitionOptions& options, const Constraints& constraints, Job& job) const;
  Partition by_planes(const PartitionOptions& options, const Constraints& constraints, Job& job) const;
  Partition with_all_components(const PartitionOptions& options, const Constraints& constraints, Job& job) const;
  Partition on_kept(const Components& components, const PartitionOptions& options, const Constraints& constraints,
                    Job& job) const;
  Partition on_part(const Surface& surface, std::span<const std::int32_t> open, const PartitionOptions& options,
                    const Constraints& constraints, Job& job) const;
  Partition on_surface(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;
  Partition with_weights(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;
  std::vector<std::int32_t> small_regions(const Surface& surface, Kept kept, const PartitionOptions& options,
                                          bool has_tree, Job& job) const;
  std::shared_ptr<const DetailTree> detail_tree(const Surface& surface, Kept& kept, const PartitionOptions& options,
                                                Job& job) const;
  Partition found_by_detail(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;
  Partition by_known_number(const Surface& surface, Kept kept, const PartitionOptions& options, Job& job) const;

  const Mesh* mesh_;
  Keep keep_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<Kept> kept_;
  mutable std::shared_ptr<const Submesh> submesh_;
  std::unique_ptr<Thesis> thesis_;
};

/// The number of regions whose polygons make about `triangles` triangles, on a mesh of `faces` faces.
std::int32_t proxies_for(std::int32_t triangles, std::int32_t faces);

/// One partition of a surface, with nothing kept: as Partitioner::run, with the guides in the surface.
Partition partition(const Surface& surface, const PartitionOptions& options, Job& job);

}  // namespace isimp
