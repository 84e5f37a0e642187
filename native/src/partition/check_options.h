#pragma once

#include "isimp/partition/partition.h"

namespace isimp {

/// \throws InvalidInput  an option out of its range, two ways to choose the number of regions, or a back end that is
/// not
///                       here: the message names the range and what was given
void check(const Surface& surface, const PartitionOptions& options);

}  // namespace isimp
