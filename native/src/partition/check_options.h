#pragma once

#include "isimp/partition/partition.h"

namespace isimp {

/// \throws InvalidInput  an option out of its range, or two ways to choose the number of regions: the message names the
///                       range and what was given
void check(const Surface& surface, const PartitionOptions& options);

}  // namespace isimp
