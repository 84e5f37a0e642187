#pragma once

#include <cstdint>
#include <optional>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/tiles/merge.h"
#include "isimp/tiles/patches.h"

namespace isimp::tiles {

/// What a tile adds to the size and the noise of the whole scan.
struct Extent {
  double area = 0.0;           ///< scene units squared
  Vec3 centre = Vec3::Zero();  ///< centroid of the surface, the caller's coordinates
  double spread = 0.0;         ///< mean squared distance of the surface's points from it, scene units squared
  double noise = 0.0;          ///< standard deviation along the normal, scene units
};

/// Cost: O(F).
Extent measure(const Mesh& mesh, Job& job);

/// Splits a tile into patches that stand for all detail of a tolerance t: as a partition with this tolerance does, but
/// merges end at 2.5 deviations of the noise in place of 3.5. No component is left out.
///
/// \param tolerance  t, above 0, scene units
/// \param noise      of the whole scan, at least 0, scene units
/// \throws InvalidInput  a tolerance or noise out of range
/// \throws Cancelled     nothing was made
/// Cost: O(F log F) time; about 200 bytes a face at the peak, with the mesh.
Patches detail_patches(const Mesh& mesh, double tolerance, double noise, Job& job);

/// How many regions a scan has at a tolerance, and where its merges were cut for that.
struct FoundRegions {
  std::int32_t regions = 0;
  double cost = 0.0;     ///< merges up to this were made, scene units squared
  bool snapped = false;  ///< the number is that of the shape's planes; see hierarchy/choose_cut.h
};

/// Merges that cost less are made wherever the joined graph is cut at this tolerance, scene units squared.
double least_cost(double tolerance, double noise);

/// Merges the joined graph to one tree and cuts it at a tolerance, as a partition of one piece does.
///
/// \param noise  of the whole scan, scene units
/// \param snap   as PartitionOptions::snap
/// \param cost   the tree is cut there; nothing: chosen by the tolerance
/// \throws InvalidInput  arrays of unequal lengths, a pair or a component out of range
/// \throws Cancelled     nothing was made
/// Cost: O(K log K) where nodes have few neighbours.
FoundRegions find_regions(const JoinedGraph& graph, const Components& components, double tolerance, double noise,
                          bool snap, std::optional<double> cost, Job& job);

}  // namespace isimp::tiles
