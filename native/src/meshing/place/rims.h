#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "isimp/meshing/polygonize.h"
#include "judge/defects.h"

/// Straight rims: the border of an open scan is ragged, and its corners are chosen by a length found from that.
namespace isimp::meshing {

/// Moves corners at the rim to where the lines through the border on both sides meet, within MeshingOptions::reach: in
/// the plane of a polygon that has the corner alone, along the edge of two polygons that share it, as far
/// as polygons stay sound.
void straighten_rims(State& state, Defects& defects, Job& job);

/// The area between the border of the scan and the rims of the polygons, in the polygons' planes.
RimReport rims_of(const State& state);

}  // namespace isimp::meshing
