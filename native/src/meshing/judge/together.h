#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/meshing/polygonize.h"

namespace isimp::meshing {

/// Checks what judge_together says of its input.
void check_parts(const PolygonMesh& mesh, std::span<const std::int32_t> part);

/// Places relative to the first vertex of a mesh, so that rounding to float32 loses little far from zero.
std::vector<Vec3> near_zero(const PolygonMesh& mesh, std::span<const Vec3> places);

/// The corners of a polygon.
inline std::span<const std::int32_t> loop_of(const PolygonMesh& mesh, std::int32_t q) {
  return std::span(mesh.loops).subspan(mesh.loop_start[q], mesh.loop_end(q) - mesh.loop_start[q]);
}

}  // namespace isimp::meshing
