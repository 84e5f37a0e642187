#pragma once

#include <string>

#include "isimp/core/errors.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// \throws InvalidInput  the partition is of another number of faces
inline void check_is_of(const Mesh& mesh, const Partition& partition) {
  if (partition.face_region.size() != static_cast<std::size_t>(mesh.face_count()))
    throw InvalidInput("the partition has " + std::to_string(partition.face_region.size()) +
                       " faces and the mesh has " + std::to_string(mesh.face_count()) +
                       ": it was made for another mesh");
}

}  // namespace isimp
