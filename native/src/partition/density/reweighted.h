#pragma once

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The surface with the areas that options.adaptivity gives it: a partition of it has denser regions where the original
/// is rough.
/// Cost: O(F).
Surface reweighted(const Surface& surface, const PartitionOptions& options, Job& job);

/// A partition of the reweighted surface as one of the original: sums and errors are those of the original areas.
/// Cost: O(F).
Partition on_original_weights(const Surface& surface, Partition of_reweighted, const PartitionOptions& options,
                              Job& job);

}  // namespace isimp
