#pragma once

#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Weights that are high where the surface is rough, so that regions get small there.
///
/// With q the deviation of the normals within about a hundredth of the size, less the share of noise, and q0 its mean:
/// w = ((q + .1 q0) / (1.1 q0))^adaptivity, clamped to [1/8, 8], scaled so that the area does not change.
/// \param adaptivity  in (0, 1]
/// \return (n) by graph index
/// Cost: O(F).
std::vector<float> adaptive_weights(const Surface& surface, double adaptivity, const Threads& threads, Job& job);

}  // namespace isimp
