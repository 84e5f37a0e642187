#pragma once

#include <span>
#include <vector>

#include "polygons.h"

namespace isimp::meshing {

/// How far each corner may be moved from its mesh vertex: `reach`, and no further than its shortest edge is long.
std::vector<double> radii(const Polygons& polygons, const Mesh& mesh, double reach);

/// Puts each corner where the planes of the pieces round it meet, by least squares from its mesh vertex; directions in
/// which they hardly fix a point are left out, and no corner is moved further than its radius.
/// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 4; the truncation as in Kobbelt et al. 2001.
std::vector<Vec3> place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
                        std::span<const double> radius);

/// Makes polygons flat by turns: a plane for each polygon, then each corner to the mean of its projections on the
/// planes round it, within its radius. Polygons that are flat already do not move.
void flatten(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes, std::span<const double> radius,
             int rounds, std::vector<Vec3>& position);

}  // namespace isimp::meshing
