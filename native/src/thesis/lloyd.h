#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/regions.h"

namespace isimp {

/// Flooding and fitting in turn from the given seeds, until the labels do not change or `iterations` rounds are done.
///
/// A round floods from the seeds, fits a proxy to each region, and makes the face nearest to it the new seed. The error
/// need not fall from round to round: the best state is returned.
/// \param history  the error after each round is appended, as a share of the whole surface's area
/// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.
Regions lloyd(const FaceGraph& graph, std::vector<std::int32_t> seeds, std::int32_t iterations,
              std::vector<double>& history, Job& job);

}  // namespace isimp
