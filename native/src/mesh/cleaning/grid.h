#pragma once

#include <Eigen/Core>
#include <optional>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp::detail {

/// A grid of cells, with its axes as columns.
struct Grid {
  double cell = 0;  ///< scene units; 0: none
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

/// The grid of occupied and empty cells that marching cubes made a mesh of, along the axes or turned. A mesh of signed
/// distances has its vertices anywhere along the edges of the grid, and is of none.
/// Cost: O(V log V).
Grid find_grid(const MeshArrays& arrays);

/// Smooths the stair steps of a mesh that marching cubes made of occupied and empty cells.
///
/// Each vertex stays within half a cell of its place along every axis, since such a grid is not more exact; vertices of
/// the border stay. First the surface shrinks, which flattens steps and rounds edges. Then it follows its normals, which
/// are filtered so that edges become sharp again.
/// \param cell  scene units; nothing: found; 0: steps stay
/// \return whether it was such a mesh; then `arrays.cell` is set
/// Source: Gibson 1998 (constrained elastic surface nets); Zheng, Fu, Au, Tai 2011 (filtered normals).
/// Cost: as find_grid, and O(300 (V + F)) where it is.
bool smooth_steps(MeshArrays& arrays, const Topology& topology, std::optional<double> cell, RepairLog& log,
                  const Threads& threads, Job& job);

}  // namespace isimp::detail
