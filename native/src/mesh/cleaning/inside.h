#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp::detail {

/// The faces of components that are inside a closed one: several of their vertices are, and their box is. Components
/// that touch or cross each other stay.
/// \return (F) marks; empty if there are none
/// Cost: O(V + F), and for each face of the largest closed components the components inside its box that are beside it.
std::vector<std::uint8_t> inner_faces(const MeshArrays& arrays, const Topology& topology, Job& job);

}  // namespace isimp::detail
