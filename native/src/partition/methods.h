#pragma once

#include "hierarchy/detail_tree.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

/// The check of options, and the ways to a partition by Method::hierarchy or with adaptivity. Each takes ready-made
/// data and options that `check` has passed; the Partitioner decides which one runs, and what data is kept from one
/// call to the next.
namespace isimp {

/// \throws InvalidInput  an option out of its range, or two ways to choose the number of regions: the message names the
///                       range and the value
void check(const Surface& surface, const PartitionOptions& options);

/// Whether the method, or its seeding, begins with a hierarchy.
bool needs_hierarchy(const PartitionOptions& options);

/// Exactly options.proxies regions, or as many as the components need: Method::hierarchy.
/// \param hierarchy  a hierarchy for this surface and number
Partition by_number(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options, Job& job);

/// Few regions that keep options.bound: Method::hierarchy.
Partition by_bound(const Surface& surface, const PartitionOptions& options, Job& job);

/// The settings of the tree from which options.detail, options.tolerance or the default detail is cut.
DetailSettings detail_settings(const Surface& surface, const PartitionOptions& options);

/// As many regions as the surface shows at a tolerance: Method::hierarchy.
/// \param tree  with detail_settings(surface, options)
Partition by_detail(const Surface& surface, const DetailTree& tree, const PartitionOptions& options, Job& job);

/// The surface with the areas that options.adaptivity gives it: a partition of it has denser regions where the original
/// is rough.
/// Cost: O(F).
Surface reweighted(const Surface& surface, const PartitionOptions& options, Job& job);

/// Restores the original weights in a partition of the reweighted surface: sums and errors are those of the original
/// areas.
/// Cost: O(F).
Partition on_original_weights(const Surface& surface, Partition of_reweighted, const PartitionOptions& options,
                              Job& job);

}  // namespace isimp
