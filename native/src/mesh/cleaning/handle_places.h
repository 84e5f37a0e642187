// Finds where the handles of a surface are.
#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp::detail {

/// Some vertices of the surface near its handles, two a handle or more, rising; none if there is no handle.
/// Cost: O(F), and O(F / 40 log F) for the trees.
std::vector<std::int32_t> places_of_handles(const MeshArrays& arrays, const Topology& topology, Job& job);

}  // namespace isimp::detail
