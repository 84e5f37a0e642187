#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh.h"

namespace isimp {

/// For each face of a cleaned mesh, the places of its corners on the caller's triangles, to transfer UVs and colours
/// per corner.
struct SourceCorners {
  std::vector<std::int32_t> face;            ///< (F) one of the caller's triangles; kNone for a cover of a hole
  std::vector<std::array<float, 6>> weight;  ///< (F) of its corners 1 and 2, for each corner of the mesh's face
  std::int64_t turned = 0;                   ///< faces whose edges `clean` flipped, halved or moved
  std::int64_t lost = 0;                     ///< faces whose corners lie on no triangle: their face is kNone
};

/// A face with the corners of its source, in any order, takes them as they are. Other faces result from edge flips,
/// halved edges and welding. They take the places of their corners on one of the source triangles of the face and its
/// neighbours: the one nearest to the corners.
///
/// \param vertices   (V) of the arrays that the mesh was made from
/// \param triangles  (T)
/// \throws InvalidInput  the mesh was made from other arrays
/// Cost: O(F).
SourceCorners source_corners(const Mesh& mesh, std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                             Job& job);

}  // namespace isimp
