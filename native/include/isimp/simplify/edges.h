#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"

/// Edges of a mesh to use as barriers or cuts: sharp ones, and edges that a caller has marked.
namespace isimp {

using VertexPair = std::array<std::int32_t, 2>;

/// The edges between two faces, by lower vertex, then by upper vertex.
struct InnerEdges {
  std::vector<VertexPair> edges;           ///< (K) the lower vertex first
  std::vector<std::int32_t> face, beside;  ///< (K) the two faces: first the one whose half-edge has the lower number
};

/// Cost: O(V + F).
InnerEdges inner_edges(const Mesh& mesh, Job& job);

/// Edges between two faces at which the surface bends by more than an angle, in the order of inner_edges. Faces without
/// area bend nowhere.
/// \param angle  radians
/// \throws InvalidInput  the angle is not in [0, pi]
/// Cost: O(V + F).
std::vector<VertexPair> sharp_edges(const Mesh& mesh, double angle, Job& job);

/// The edges between two faces that a caller has marked before `clean`, in the order of inner_edges. Edges whose faces
/// were removed are left out.
/// \param marked  (K) pairs of the caller's vertices (Mesh::source_vertex), any numbers
/// Cost: O(V + F + K) plus the search of the marked edges at the vertices.
std::vector<VertexPair> marked_edges(const Mesh& mesh, std::span<const VertexPair> marked, Job& job);

}  // namespace isimp
