#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Joins regions that are strips of edges with the adjacent planes, so that rounded and dented edges become sharp.
///
/// A region is a strip if it is at most `width` wide, hardly on the border, mostly along wider regions, and its normal
/// lies between the normals of two of them that meet at more than 25 degrees: roundings and chamfers, convex and
/// concave. Ridges, grooves and steps stay. Its faces join the neighbours by normal and distance from planes that are
/// fitted robustly. A strip is restored if its faces are further than half the width from those planes. At most three
/// rounds.
/// \param width  scene units; 0: three mean edges, since a narrower strip of a scan is no different from an edge
/// \param least  number of regions that are left at least: the narrowest strips join first
/// \return (F) labels, each region connected; nothing where no region is a strip
/// Cost: O(F), and O(f log f) for f faces of strips.
std::optional<std::vector<std::int32_t>> without_strips(const Mesh& mesh, const Partition& partition, double width,
                                                        std::int32_t least, Job& job);

/// Whether regions from a detail are flat below the scan's noise, as on things made of planes: half of the area is
/// nearer to the planes of its regions than the noise's standard deviation, and a region has a hundred faces in the
/// mean. There a narrow region at an edge is no shape of its own.
/// Cost: O(F).
bool is_of_planes(const Mesh& mesh, const Partition& partition);

}  // namespace isimp
