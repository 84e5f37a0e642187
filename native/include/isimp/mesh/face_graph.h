#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/core/types.h"

namespace isimp {

using Box = Eigen::AlignedBox3d;

/// The data of a face that partitioning needs, in one 16-byte record.
struct FaceRecord {
  float nx = 0, ny = 0, nz = 0;  ///< unit normal; a face without area has the normal of the nearest face with one
  float area = 0;                ///< as a share of the whole surface's area
};

/// The dual graph of a mesh, its faces in Morton order so that near faces are near in memory.
///
/// Index n = size() is a sentinel: it stands for "no neighbour", so that a loop over neighbours needs no test.
struct FaceGraph {
  Array<FaceRecord> faces;                        ///< (n + 1), the last one all zero
  Array<std::array<std::int32_t, 3>> neighbours;  ///< (n + 1), across corner k -> k + 1; n where none
  Array<std::int32_t> mesh_face;                  ///< (n) graph index -> face of the mesh
  Array<std::int32_t> graph_face;                 ///< (n) face of the mesh -> graph index
  double area = 0.0;                              ///< area of the whole surface, scene units squared

  [[nodiscard]] std::int32_t size() const { return static_cast<std::int32_t>(mesh_face.size()); }
};

/// Builds the graph. A face is without area if its doubled area is below 1e-12 of its longest edge squared.
///
/// \param opposite  (3 F) half-edge across each, kNone on borders
/// \param box       bounding box of all faces
/// Cost: O(F) by a radix sort. The result does not depend on the number of threads.
FaceGraph make_face_graph(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                          std::span<const std::int32_t> opposite, const Box& box, const Threads& threads, Job& job);

}  // namespace isimp
