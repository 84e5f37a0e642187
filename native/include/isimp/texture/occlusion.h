#pragma once

#include <cstdint>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "isimp/texture/bake.h"
#include "isimp/texture/options.h"

namespace isimp {

/// Ambient occlusion: for each texel, the share of the light from all directions that reaches its place on the scan,
/// from 0 to 255. 255: no face of the scan is in the way. Faces without polygons stop no ray.
///
/// Rays start at the scan's surface, cosine-weighted about its smoothed normal, and are stopped by any face of the scan
/// within `occlusion_distance`. Each texel sends a ninth of `occlusion_rays`; three by three texels together send all of
/// them, and each texel shows the mean of these nine. Texels outside of polygons are flooded.
///
/// \param map  made by `bake_map` for this mesh and partition
/// \return (side * rows) rows from the top
/// \throws InvalidInput  a map that is not of this mesh, or an option out of its range
/// \throws Cancelled     nothing was made
/// Cost: about 0.5 us a ray and core. The result does not depend on the number of threads.
Array<std::uint8_t> occlusion(const Mesh& mesh, const Partition& partition, const BakeMap& map,
                              const TextureOptions& options, Job& job);

}  // namespace isimp
