#pragma once

#include "isimp/partition/partition.h"

namespace isimp {

/// What `before` knows, said of a partition each of whose regions lies in one of its: planes that keep a bound, locks,
/// and how the number was found.
/// \throws InvalidInput  they are of different numbers of faces
Partition inherited(Partition part, const Partition& before);

}  // namespace isimp
