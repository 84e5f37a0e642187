// Checks of a whole partition.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The first region whose faces are not connected, kNone if there is none. Barriers do not connect faces.
/// \param face_region  (F) in [-1, regions)
/// Cost: O(F).
std::int32_t find_unconnected(const Surface& surface, std::span<const std::int32_t> face_region, std::int32_t regions);

/// The first promise that a partition breaks whatever its mesh is; empty if it keeps all: arrays of R, labels in [-1, R),
/// regions that are not empty, seeds in their regions, sums of as many faces as the labels have, normals of length 1 or
/// 0, finite offsets, and round parts with all their numbers, whose cells are regions with held planes.
/// Cost: O(F).
std::string broken_arrays(const Partition& partition);

/// The first promise that a partition breaks, for assertions and tests; empty if it keeps all: those of `broken_arrays`,
/// a label for each face, and regions that are connected.
/// \param surface  the surface with the guides of the partition
/// Cost: O(F).
std::string broken_promise(const Surface& surface, const Partition& partition);

}  // namespace isimp
