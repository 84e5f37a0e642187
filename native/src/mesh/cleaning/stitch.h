#pragma once

#include <optional>
#include <vector>

#include "isimp/core/job.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp::detail {

/// Triangles in which borders that were near each other share their vertices; no longer manifold, to be made so again.
struct Stitched {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> source_face;  ///< the face of the arrays that each was
  double distance;                        ///< up to which borders were joined, scene units
};

/// Joins borders of chunks of a scan whose vertices do not match: each border vertex moves to the nearest edge of
/// another border, that of another component or one beyond a gap, whose face lies the same way within 60 degrees,
/// either side up. Near an end of that edge both become one vertex, else the vertex is put into the edge.
/// \param distance  scene units; nothing: two mean edges, if a tenth of the border and at least 100 vertices have the
///                 border of another component that near, and the mesh has more faces than border edges
/// \param log  gets the stitched vertices
/// \return nothing where there is nothing to stitch
/// Cost: O(V + F), and for b border edges O(b), times the edges within two distances or two mean edges of a vertex.
std::optional<Stitched> stitch(const MeshArrays& arrays, const Topology& topology, std::optional<double> distance,
                               RepairLog& log, Job& job);

}  // namespace isimp::detail
