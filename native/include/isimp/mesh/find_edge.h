#pragma once

#include <cstdint>

#include "isimp/mesh/mesh.h"

namespace isimp {

/// The half-edge between two vertices, in either direction; kNone if there is no such edge, or no such vertex.
/// Cost: the faces at the first vertex.
std::int32_t find_edge(const Mesh& mesh, std::int32_t a, std::int32_t b);

}  // namespace isimp
