// The graph of regions that share an edge.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "hierarchy/contraction.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The pairs (u, v) of regions that share an edge, in both directions, in rising order.
/// \param label  (n + 1) by graph index, kNone for the sentinel
/// \param faces  among which all border faces are
std::vector<std::pair<std::int32_t, std::int32_t>> neighbouring_regions(const FaceGraph& graph,
                                                                        const std::vector<std::int32_t>& label,
                                                                        std::span<const std::int32_t> faces,
                                                                        const Threads& threads = Threads(1));

/// The graph of regions that share an edge, in the form for merging, with empty sums.
/// \param component  (R) component of each; may be empty
MergeGraph graph_of_regions(const FaceGraph& graph, const std::vector<std::int32_t>& label, std::size_t regions,
                            std::vector<std::int32_t> component, std::span<const std::int32_t> faces,
                            const Threads& threads = Threads(1));

/// The lengths of the borders between regions; with weights, times their worth there (worth_of in border_moves.h).
/// \param label  as in the graph of these regions
/// \param faces  among which all border faces are
/// \return as touching.neighbour, as a share of the root of the surface's area
std::vector<double> border_lengths(const Surface& surface, const std::vector<std::int32_t>& label,
                                   std::span<const std::int32_t> faces, const MergeGraph& touching,
                                   const Threads& threads);

}  // namespace isimp
