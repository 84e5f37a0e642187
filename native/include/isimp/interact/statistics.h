#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// What there is to say of one region. Its plane is that of its normal through its centroid.
struct RegionStatistics {
  std::int32_t region = kNone;
  std::int32_t faces = 0;
  double area = 0.0;          ///< scene units squared
  double error = 0.0;         ///< its share of Partition::error: with the weights, if there are any
  double distance_rms = 0.0;  ///< root of the mean square of the surface's distance from the plane, scene units
  double distance_max = 0.0;  ///< largest distance of a vertex from the plane, scene units
  bool locked = false;        ///< see interact/lock.h
  std::vector<std::int32_t> neighbours;  ///< regions it shares an edge with, rising
};

/// Of the region of a face.
/// \throws InvalidInput  a face outside [0, F) or left out; another mesh's partition
/// Cost: O(n log n), n the faces of the region; O(F) bits of memory.
RegionStatistics region_statistics(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

/// Of every region, in their order.
/// \throws InvalidInput  another mesh's partition.
/// \throws Cancelled
/// Cost: O(F).
std::vector<RegionStatistics> all_statistics(const Mesh& mesh, const Partition& partition, Job& job);

}  // namespace isimp
