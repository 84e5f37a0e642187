#pragma once

#include <cstdint>
#include <span>

#include "isimp/partition/partition.h"

namespace isimp {

/// Removes all other regions from the arrays by region; labels of faces stay as they are.
/// \param regions  to be kept, in rising order; each gets its place there as its number
/// Cost: O(R).
void keep_regions(Partition& partition, std::span<const std::int32_t> regions);

/// Renumbers labels and seeds of a partition of a part as faces of the whole mesh. Other faces are in no region.
/// \param face   by face of the part: the face of the whole
/// \param count  number of faces of the whole
/// Cost: O(F + R).
void to_whole_faces(Partition& partition, std::span<const std::int32_t> face, std::size_t count);

}  // namespace isimp
