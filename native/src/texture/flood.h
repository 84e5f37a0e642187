#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/job.h"
#include "isimp/texture/bake.h"
#include "sampler.h"

namespace isimp::detail {

/// Gives the pixels of a tile that nobody owns the mean of those around them, from coarser and coarser copies of the
/// tile, so that reduced copies of it show no foreign colour at the charts' borders.
/// \param owner  (side * rows) rows from the bottom; kNone: nobody
/// \param rgba   (4 side * rows) rows from the top
void flood(std::span<const std::int32_t> owner, std::int32_t side, std::int32_t tile, const Rgba& mean,
           std::span<std::uint8_t> rgba, Job& job);

/// Gives them flat normals, in all tiles.
/// \param normal  (3 side * rows) rows from the top
void flood_normals(std::span<const std::int32_t> owner, std::int32_t side, std::span<std::uint8_t> normal);

}  // namespace isimp::detail
