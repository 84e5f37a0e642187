#include "isimp/tiles/noise.h"

#include "density/noise.h"

namespace isimp::tiles {

double noise(const Mesh& mesh, Job& job) { return estimate_noise(mesh, Threads(1), job); }

}  // namespace isimp::tiles
