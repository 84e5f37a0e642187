#pragma once

#include "cells/patches.h"

namespace isimp::curved {

/// The partition with the cells of patches in the place of its regions there. Regions elsewhere stay. A small rest of a
/// region next to a patch joins its neighbours.
/// \param scene  patches with segments and rings; those without segments are left as they are
/// Cost: O(F).
Partition with_cells(const Surface& surface, const Partition& part, Scene scene, Job& job);

}  // namespace isimp::curved
