#pragma once

#include <cstdint>
#include <span>

#include "isimp/partition/partition.h"

namespace isimp {

/// Removes all other regions from the arrays by region; labels of faces stay as they are.
/// \param regions  to be kept, in rising order; each gets its place there as its number
/// Cost: O(R).
void keep_regions(Partition& partition, std::span<const std::int32_t> regions);

}  // namespace isimp
