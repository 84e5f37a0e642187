#pragma once

#include <cstdint>

#include "edit.h"

namespace isimp {

/// Adds a region, the last one, that cuts a corner or an edge which was rounded, at a face on it.
///
/// Splitting the one region that the face is in would not do there: the round belongs to all regions that meet in it.
/// Its direction is half-way between theirs. Faces go over from all sides that turn that way rather than their
/// region's; at a corner all that lie above a plane across it, so that its outline is a polygon and not a star with an
/// arm down each edge, which the error alone would prefer.
/// \return false, with nothing done, where the face lies on no such place
bool grow_bevel(Edit& edit, const Partition& before, std::int32_t face, Job& job);

}  // namespace isimp
