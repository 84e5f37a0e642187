#pragma once

#include <cstdint>
#include <span>

#include "images/sampler.h"
#include "isimp/core/job.h"
#include "isimp/texture/bake.h"

namespace isimp::detail {

/// Fills the pixels of a tile without an owner with the mean of the pixels around them, from coarser and coarser copies
/// of the tile, so that reduced copies of it show no foreign colour at the charts' borders.
/// \param owner  (side * rows) rows from the bottom; kNone: no owner
/// \param rgba   (4 side * rows) rows from the top
void flood(std::span<const std::int32_t> owner, std::int32_t side, std::int32_t tile, const Rgba& mean,
           std::span<std::uint8_t> rgba, Job& job);

/// Sets flat normals for these pixels, in all tiles.
/// \param normal  (3 side * rows) rows from the top
void flood_normals(std::span<const std::int32_t> owner, std::int32_t side, std::span<std::uint8_t> normal);

}  // namespace isimp::detail
