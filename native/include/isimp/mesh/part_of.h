#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"

namespace isimp {

/// Returns some faces of a mesh as a mesh of their own, without new adjacencies. Its source_vertex names vertices of the
/// whole mesh. A vertex where faces of the part touch without a common edge is copied.
/// \param source_face  the source_face of each of `faces` in the part; empty: its place in `faces`
/// \throws InvalidInput  no faces, or one out of range (named)
/// Cost: O(faces of the whole mesh).
Mesh part_of(const Mesh& mesh, std::span<const std::int32_t> faces, Job& job,
             std::span<const std::int32_t> source_face = {});

}  // namespace isimp
