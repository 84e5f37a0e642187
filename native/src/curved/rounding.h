#pragma once

#include "patches.h"

namespace isimp::curved {

/// The partition with the cells of patches in the place of its regions there. Regions elsewhere stay; what is left of
/// one beside a patch and small goes to its neighbours.
/// \param scene  patches with segments and rings; those without segments are left as they are
/// Cost: O(F).
Partition with_cells(const Surface& surface, const Partition& part, Scene scene, Job& job);

}  // namespace isimp::curved
