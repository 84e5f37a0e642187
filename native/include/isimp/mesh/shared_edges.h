#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"

namespace isimp {

/// Pairs of triangles that share an edge.
struct SharedEdges {
  std::vector<std::array<std::int32_t, 2>> edges;  ///< (E) their vertices, the lower one first
  std::vector<std::int32_t> face, beside;          ///< (E) the triangles
};

/// The pairs of any triangles, also where they make no manifold. An edge of two triangles gives one pair, one of three
/// gives three; of more, each triangle is paired with the next two. All pairs with the next triangle precede all pairs
/// with the next but one; both are sorted by lower vertex, then by upper vertex, then by triangle.
/// \param vertex_count  above all vertices of the triangles, none of which is negative
/// Cost: O(vertex_count + F), 24 bytes a face in addition to the result.
SharedEdges shared_edges(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job);

}  // namespace isimp
