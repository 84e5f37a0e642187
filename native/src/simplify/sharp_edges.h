#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Gives regions that are strips of edges to the planes beside them, so that rounded and dented edges become sharp.
///
/// A region is a strip if it is at most `width` wide, hardly on the border, most of it is beside wider regions, and its
/// normal lies between those of two of them that meet at more than 25 degrees: roundings and chamfers, convex and
/// concave. Ridges, grooves and steps stay. Its faces go to the neighbours by normal and distance from planes that are
/// fitted robustly. A strip comes back if its faces are further than half the width from those planes. At most three
/// rounds.
/// \param width  scene units; 0: three mean edges, since the scan can't tell less from an edge
/// \return (F) labels, each region connected; nothing where no region is a strip
/// Cost: O(F), and O(f log f) for f faces of strips.
std::optional<std::vector<std::int32_t>> without_strips(const Mesh& mesh, const Partition& partition, double width,
                                                        Job& job);

}  // namespace isimp
