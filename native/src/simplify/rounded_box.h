#pragma once

#include <cmath>
#include <limits>

#include "isimp/core/types.h"
#include "judge/boxes.h"

namespace isimp {

/// The box of floats that contains one of doubles: rounded away from the middle.
inline meshing::Box box_between(const Vec3& low, const Vec3& high) {
  meshing::Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::nextafter(static_cast<float>(low[k]), -std::numeric_limits<float>::infinity());
    box.high[k] = std::nextafter(static_cast<float>(high[k]), std::numeric_limits<float>::infinity());
  }
  return box;
}

}  // namespace isimp
