#pragma once

#include <cstdint>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

/// The choices that Cohen-Steiner, Alliez, Desbrun 2004, section 3.5, leave to the machine, several at a time. Locked
/// regions are neither chosen nor changed. Ties prefer the region of the lower number.
namespace isimp {

/// Splits the region whose split lowers the error most, `times` times, with split_region. Noise on a large wall adds to
/// its error, but no split removes it. Where no split lowers the error, the region with most faces is split.
/// \throws InvalidInput  times below 1; no region left that is not locked and has two faces: nothing was changed
/// \throws Cancelled  nothing was changed
/// Cost: O(F log F) at most for the first one, then that of a split_region each.
Partition add_worst(const Mesh& mesh, const Partition& partition, std::int32_t times, Job& job);

/// Deletes, `times` times, the region whose merge with one of its neighbours would raise the error least.
/// \throws InvalidInput  times below 1; no region left that is not locked and has such a neighbour: nothing was changed
/// \throws Cancelled     nothing was changed
/// Cost: O(F) once, and a few milliseconds each.
Partition delete_least(const Mesh& mesh, const Partition& partition, std::int32_t times, Job& job);

/// Merges the two neighbours whose merge raises the error least, `times` times, with merge_regions.
/// \throws as  delete_least.
/// Cost: as delete_least.
Partition merge_cheapest(const Mesh& mesh, const Partition& partition, std::int32_t times, Job& job);

/// Relaxes all borders and moves regions from places where they are worth little to places where they are worth much,
/// until no move helps; the number of regions stays. The result is never worse than the input, and at worst equal to
/// it.
/// \throws Cancelled  nothing was changed
/// Cost: O(F) and up to a few times the time of the partition.
Partition improve(const Mesh& mesh, const Partition& partition, Job& job);

/// Makes all borders short and straight; the number of regions stays. Faces move between neighbouring regions as long
/// as that lowers the error plus the length of the borders, weighted as in a partition of this smoothness. So creases
/// stay borders. Regions stay connected, and no face leaves or enters a locked one.
/// \param strength  in [0, 1], as PartitionOptions::smooth. 0: only teeth that cost no error are removed
/// \throws InvalidInput  strength out of its range
/// \throws Cancelled     nothing was changed
/// Cost: O(F) and the moves.
Partition even_borders(const Mesh& mesh, const Partition& partition, double strength, Job& job);

}  // namespace isimp
