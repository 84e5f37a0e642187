#pragma once

#include <vector>

#include "isimp/meshing/moments.h"

namespace isimp::bindings {

/// So that the caller need not keep an array of its own too.
struct KeptMoments {
  std::vector<SurfaceMoments> of_face;
};

}  // namespace isimp::bindings
