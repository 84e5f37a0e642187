#pragma once

#include <cstdint>
#include <optional>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/tiles/merge.h"
#include "isimp/tiles/patches.h"

namespace isimp::tiles {

/// Measures of a tile. The size and the noise of the whole scan follow from the measures of all tiles.
struct Extent {
  double area = 0.0;           ///< scene units squared
  Vec3 centre = Vec3::Zero();  ///< centroid of the surface, the caller's coordinates
  double spread = 0.0;         ///< mean squared distance of the surface from the centre, scene units squared
  double noise = 0.0;          ///< standard deviation along the normal, scene units
};

/// Cost: O(F).
Extent measure(const Mesh& mesh, Job& job);

/// Splits a tile into patches that show all detail at a tolerance t. Merging is the same as in a partition with this
/// tolerance, but it ends at 2.5 deviations of the noise instead of 3.5. No component is left out.
///
/// \param tolerance  t, above 0, scene units
/// \param noise      noise of the whole scan, at least 0, scene units
/// \throws InvalidInput  a tolerance or noise out of range
/// \throws Cancelled     no result
/// Cost: O(F log F) time; about 200 bytes a face at the peak, with the mesh.
Patches detail_patches(const Mesh& mesh, double tolerance, double noise, Job& job);

/// The number of regions of a scan at a tolerance, and the cost at which its merges were cut for it.
struct FoundRegions {
  std::int32_t regions = 0;
  double cost = 0.0;     ///< merges up to this cost were made, scene units squared
  bool snapped = false;  ///< the number is the shape's own number of planes; see hierarchy/choose_cut.h
};

/// The cost below which `find_regions` makes every merge at this tolerance, scene units squared.
double least_cost(double tolerance, double noise);

/// Merges the joined graph to one tree and cuts it at a tolerance, as a partition of one piece does.
///
/// \param noise  noise of the whole scan, scene units
/// \param snap   as PartitionOptions::snap
/// \param cost   cost at which the tree is cut; nothing: the tolerance determines it
/// \throws InvalidInput  arrays of unequal lengths, a pair or a component out of range
/// \throws Cancelled     no result
/// Cost: O(K log K) if nodes have few neighbours.
FoundRegions find_regions(const JoinedGraph& graph, const JoinedComponents& components, double tolerance, double noise,
                          bool snap, std::optional<double> cost, Job& job);

}  // namespace isimp::tiles
