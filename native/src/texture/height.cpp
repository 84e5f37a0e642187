#include "isimp/texture/height.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isimp/core/to_integer.h"
#include "isimp/core/types.h"

namespace isimp {

HeightImage height_image(const BakeMap& map, double least) {
  float most = 0;
  for (std::size_t i = 0; i < map.height.size(); ++i)
    if (map.polygon[i] != kNone && map.face[i] != kNone) most = std::max(most, std::abs(map.height[i]));
  HeightImage image;
  const bool flat = !(most > least);
  image.range = flat ? 0.0 : 2.0 * most;
  image.grey.resize(map.height.size());
  constexpr std::uint16_t kMost = std::numeric_limits<std::uint16_t>::max();
  for (std::size_t i = 0; i < map.height.size(); ++i) {
    const double height = !flat && map.face[i] != kNone ? map.height[i] / image.range : 0.0;
    image.grey[i] = to_integer(std::round((height + 0.5) * kMost), std::uint16_t{0}, kMost);
  }
  return image;
}

}  // namespace isimp
