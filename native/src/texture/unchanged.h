// Finds polygons that keep their texels from an earlier texture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/texture/bake.h"
#include "samples.h"

namespace isimp::detail {

/// The earlier polygon of each polygon with the same faces at the same texels; kNone for others.
///
/// It has the place of that one in the atlas, and the same texels. Its region has the same faces, and so have the
/// adjacent regions, in the same order: faces of equal depth are shown by that order.
///
/// \param texture  the new texture, for its size and its images
std::vector<std::int32_t> unchanged_polygons(const Scene& scene, std::span<const std::uint8_t> known,
                                             const EarlierBake& earlier, const Texture& texture, const Threads& threads,
                                             Job& job);

}  // namespace isimp::detail
