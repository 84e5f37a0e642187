#pragma once

#include "components.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/partition/options.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The last step of `optimise`.
enum class Finish {
  teleports,  ///< the worst regions are split and the cheapest pairs merged as long as that pays
  plain,  ///< no teleports, for regions that are merged again: with a few large regions on flat ground they are slow
};

/// Regions from the hierarchy, much better and faster than flooding from random seeds.
///
/// 1. Merge a coarse level greedily to some more regions than are wanted; transfer them to the patches and
///    relax the borders there, patch by patch.
/// 2. Transfer them to the faces and relax for a few sweeps; merge greedily to the wanted number, now from exact sums;
///    relax until no border moves.
/// 3. If merging can't give enough regions (few large smooth patches), split the worst; and as long as splitting the
///    worst region gains more than merging the cheapest pair costs, do both (see teleport).
/// Cost: O(F); about 40 ms for a million faces.
/// \param smooth  PartitionOptions::smooth; above 0 the borders' length is added to the error, in relaxing and in the
///                last merging
/// \param metric  of the last relaxing; all before uses normals
Regions optimise(const Surface& surface, const Hierarchy& hierarchy, const Components& components, double smooth,
                 const Threads& threads, Job& job, Finish finish = Finish::teleports, Metric metric = Metric::normals);

}  // namespace isimp
