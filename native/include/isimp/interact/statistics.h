#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// Figures of one region. Its plane has its normal and contains its centroid.
struct RegionStatistics {
  std::int32_t region = kNone;
  std::int32_t faces = 0;
  double area = 0.0;          ///< scene units squared
  double error = 0.0;         ///< its share of Partition::error, with weights if there are any
  double distance_rms = 0.0;  ///< root of the mean square of the surface's distance from the plane, scene units
  double distance_max = 0.0;  ///< largest distance of a vertex from the plane, scene units
  bool locked = false;        ///< see interact/lock.h
  std::vector<std::int32_t> neighbours;  ///< regions it shares an edge with, rising
};

/// Figures of the region of a face.
/// \throws InvalidInput  a face outside [0, F) or left out; another mesh's partition
/// Cost: O(n log n), n the faces of the region; O(F) bits of memory.
RegionStatistics region_statistics(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job);

/// Figures of all regions, in order.
/// \throws InvalidInput  another mesh's partition.
/// \throws Cancelled
/// Cost: O(F).
std::vector<RegionStatistics> all_statistics(const Mesh& mesh, const Partition& partition, Job& job);

/// Areas and normals of regions, by number.
struct RegionSides {
  std::vector<double> area;  ///< scene units squared
  std::vector<Vec3> normal;  ///< sum of area times unit normal: as long as the area where the region is flat
};

/// Sides of the regions of any triangles, sound or not; triangles with a coordinate that is not finite have no area.
/// \param region   of each triangle; kNone for none
/// \param regions  number of regions
/// \throws InvalidInput  other lengths; a vertex or a region that does not exist
/// Cost: O(T + regions).
RegionSides region_sides(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                         std::span<const std::int32_t> region, std::int32_t regions);

}  // namespace isimp
