#pragma once

#include <cstdint>

#include "isimp/core/array.h"
#include "isimp/texture/bake.h"

namespace isimp {

/// The heights of the scan above its polygons' planes, as an image.
struct HeightImage {
  Array<std::uint16_t> grey;  ///< (side * rows) rows from the top
  double range = 0;           ///< scene units: a texel lies (grey / 65535 - 0.5) * range above its polygon's plane
};

/// The heights of a map, by 16 bits. The range is twice the largest distance of a texel inside a polygon, so that a
/// plane is in the middle; heights in gutters beyond it are cut off. Texels that show no place are in the middle.
///
/// \param map    made by `bake_map`
/// \param least  scene units: if all heights are smaller, they count as rounding, the range is 0 and all is in the
///               middle
/// Cost: one pass over the texels.
HeightImage height_image(const BakeMap& map, double least);

}  // namespace isimp
