#pragma once

#include <vector>

#include "complex/joins.h"
#include "complex/state.h"
#include "isimp/core/job.h"

namespace isimp::meshing {

/// Joins pairs of junctions that a short chord connects, so that four or five charts meet in one vertex. Where a
/// surface is a saddle, three planar polygons can't all be convex at a vertex, and four can. A short edge disappears.
///
/// A join is a change of labels: the faces of one chart along the path between the junctions become faces of the chart
/// at the end that moves. It is made if
/// - there is a place that no plane of the charts misses by more than kMisses times the bound of bent polygons,
/// - no polygon at the junctions turns over or vanishes,
/// - the energy of the polygons there falls: their edges' square distances from the planes on both sides and from the
///   border that they replace, a price for each edge in square deviations of the scan, prices of reflex and sharp corners,
///   and the square distances of the faces that change their chart,
/// - all charts stay discs, and no other junction changes,
/// - no locked region changes and no bound of the partition is broken.
/// Shortest chords come first; ties go to the lower vertex.
/// Pre: `update` has placed the corners. Calls `update` where something was joined.
/// \return the joins, in the order in which they were made
/// Source: the cause is that of Li, Liu, Wang: Planar Hexagonal Meshing for Architecture, 2015; the joining is our own.
/// Cost: O(chords + faces of the charts joined).
std::vector<Join> join_junctions(State& state, Job& job);

}  // namespace isimp::meshing
