#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "edit_labels.h"

namespace isimp {

/// The faces cut off from a region, found from the faces next to the cut.
///
/// All pieces are walked through in turn, a face each, and walks that meet are merged; the last one is not walked to
/// its end, so that the cost is the size of the smaller pieces. Labels are restored afterwards.
/// \param starts  faces of one region, some in every piece.
/// \return the faces of all pieces except the last
std::vector<std::int32_t> cut_off(const FaceGraph& graph, EditLabels labels, std::span<const std::int32_t> starts);

}  // namespace isimp
