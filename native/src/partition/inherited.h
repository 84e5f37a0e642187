#pragma once

#include "isimp/partition/partition.h"

namespace isimp {

/// How the number of regions was found, and what they keep to: bound, tolerance, noise.
void take_how_found(Partition& part, const Partition& before);

}  // namespace isimp
