#pragma once

#include <vector>

#include "isimp/meshing/moments.h"

namespace isimp::bindings {

/// Moments with their arrays, so that the caller need not keep these too.
struct KeptMoments {
  std::vector<SurfaceMoments> of_face;
};

}  // namespace isimp::bindings
