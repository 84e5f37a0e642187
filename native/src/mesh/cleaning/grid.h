#pragma once

#include <optional>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp::detail {

/// Smooths the stair steps of a mesh that marching cubes made of occupied and empty cells.
///
/// Each vertex stays within half a cell of its place along every axis, since such a grid is not more exact; vertices of
/// the border stay. A mesh of signed distances, whose vertices lie anywhere along the edges of the grid, has no steps
/// and is left alone.
/// \param cell  scene units; nothing: found, with the grid along the axes or turned; 0: steps stay
/// \return whether it was such a mesh
/// Source: Gibson 1998 (constrained elastic surface nets).
/// Cost: O(V log V), and O(100 (V + F)) where it is.
bool smooth_steps(MeshArrays& arrays, const Topology& topology, std::optional<double> cell, RepairLog& log,
                  const Threads& threads, Job& job);

}  // namespace isimp::detail
