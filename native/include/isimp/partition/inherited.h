#pragma once

#include "isimp/partition/partition.h"

namespace isimp {

/// How the number of regions was found, and what they keep to: bound, tolerance, noise.
void take_how_found(Partition& part, const Partition& before);

/// What `before` knows, said of a partition each of whose regions lies in one of its: planes that keep a bound, locks,
/// and how the number was found.
/// \throws InvalidInput  they are of different numbers of faces
Partition inherited(Partition part, const Partition& before);

}  // namespace isimp
