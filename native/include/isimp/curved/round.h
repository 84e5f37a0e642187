#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Lengths by which curved patches are found, scene units.
struct RoundLengths {
  double tolerance = 0;  ///< the partition's tolerance; the default if the partition has a given number of regions
  double noise = 0;      ///< standard deviation of the scan's noise
};

/// Makes round parts round: finds cylinders, cones, spheres, surfaces of revolution and extrusions, and cuts each
/// into segments about its axis and rings along its profile, an extrusion into strips along its axis. A patch has as many cells as the partition has regions there. Each cell
/// is a region with a plane that polygons keep to (kPlaneRound). Other regions stay unchanged, except that a region at
/// the border of a patch loses its part within the patch. Without a patch the partition is returned unchanged.
///
/// \param part  the partition by planes; locked regions stay as they are
/// \param small  (F) each face's region among some hundred small ones, kNone where it is in none
/// \param stays  (F) 1 where a face keeps its region; empty: nowhere
/// \throws InvalidInput  the partition is of another mesh
/// \throws Cancelled     nothing was changed
/// Cost: O(F), and some hundred fits to as many points.
/// Source: own; fits as in Pottmann, Wallner 2001 and Gelfand, Guibas 2004.
Partition round_parts(const Surface& surface, Partition part, std::span<const std::int32_t> small,
                      const RoundLengths& lengths, std::span<const std::uint8_t> stays, Job& job);

}  // namespace isimp
