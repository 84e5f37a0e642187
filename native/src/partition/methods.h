#pragma once

#include "hierarchy/detail_tree.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

/// The ways to a partition by Method::hierarchy. Each takes what it needs ready-made and options that `check` has passed;
/// which one is taken, and what is kept from one call to the next, is decided by the Partitioner.
namespace isimp {

/// Whether the method, or its seeding, begins with a hierarchy.
bool needs_hierarchy(const PartitionOptions& options);

/// Exactly options.proxies regions, or as many as the components need: Method::hierarchy.
/// \param hierarchy  one that serves this surface and number
Partition by_number(const Surface& surface, const Hierarchy& hierarchy, const PartitionOptions& options, Job& job);

/// Few regions that keep options.bound: Method::hierarchy.
Partition by_bound(const Surface& surface, const PartitionOptions& options, Job& job);

/// The settings of the tree from which options.detail, options.tolerance or the default detail is cut.
DetailSettings detail_settings(const Surface& surface, const PartitionOptions& options);

/// As many regions as the surface shows at a tolerance: Method::hierarchy.
/// \param tree  with detail_settings(surface, options)
Partition by_detail(const Surface& surface, const DetailTree& tree, const PartitionOptions& options, Job& job);

}  // namespace isimp
