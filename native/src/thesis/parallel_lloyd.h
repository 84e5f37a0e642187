#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/parallel/flooder.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// A surface in the memory of a back end, for parallel_lloyd. The surface's mesh and guides must outlive it.
/// \throws InvalidInput  there is no such back end here; the message lists the choices
std::unique_ptr<parallel::Flooder> load(const Surface& surface, std::string_view backend);

/// Flooding and fitting in turn, each step on all faces at once: Method::naive and Method::queued.
///
/// Rounds as in lloyd(), but a region of a round may lie in several pieces. The best round's regions are made connected
/// at the end by the method options.connect; the history has the error of each round and then that of the result. The
/// labels are the same on every back end and any number of threads.
/// \param flooder  of this surface, from load()
/// \param seeds    (R) distinct graph indices, at least one in every component that is kept
/// Source: the thesis's data-parallel floodings.
Regions parallel_lloyd(const Surface& surface, parallel::Flooder& flooder, std::vector<std::int32_t> seeds,
                       const PartitionOptions& options, std::vector<double>& history, Job& job);

}  // namespace isimp
