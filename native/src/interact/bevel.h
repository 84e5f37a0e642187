#pragma once

#include <cstdint>

#include "edit.h"

namespace isimp {

/// Adds a region, the last one, that cuts a corner or an edge which was rounded, at a face on it.
///
/// Splitting the region of the face would be wrong there: the rounding belongs to all regions that meet in it. The
/// direction of the new region is half-way between theirs. Faces move from all sides that turn towards it rather than
/// towards their region's direction. At a corner all faces above a plane across it move, so that its outline is a
/// polygon and not a star with an arm down each edge, which the error alone would prefer.
/// \return false, without a change, if the face lies on no such place
bool grow_bevel(Edit& edit, const Partition& before, std::int32_t face, Job& job);

}  // namespace isimp
