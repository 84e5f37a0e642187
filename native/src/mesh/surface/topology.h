#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/core/types.h"

namespace isimp::detail {

/// The adjacency of a manifold mesh.
///
/// Half-edge h = 3 * f + k runs along face f from its corner k to its corner k + 1.
struct Topology {
  Array<std::int32_t> opposite;         ///< (3 F) the half-edge on the other side of each; kNone on a border
  Array<std::int32_t> vertex_halfedge;  ///< (V) one that leaves each vertex, on the border if there is one
  std::vector<std::int32_t> border;     ///< the half-edges without an opposite, rising
  std::int32_t unused_vertices = 0;
  std::string defect;  ///< the first defect if the mesh is not sound; the rest is then unfinished
};

/// Finds the neighbours of every face.
/// \param triangles  in range, none naming a vertex twice
/// Cost: O(V + F) by a counting sort on the smaller vertex; a vertex with d edges adds O(d log d). 12 bytes a face on
/// the way. The result does not depend on the number of threads.
Topology find_topology(std::size_t vertex_count, std::span<const Triangle> triangles, const Threads& threads, Job& job);

}  // namespace isimp::detail
