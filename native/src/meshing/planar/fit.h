#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// The corners that count for each unit: by unit, by place in its loop.
using Kept = std::vector<std::vector<std::uint8_t>>;

/// The growth of the penalty on corners off their planes, from the first to the last round.
struct Schedule {
  int rounds = 25;
  double from = 1, to = 1e6;
};

/// Sets the cost of moving each plane off its scan. It is higher if the scan is nearer to a plane than corners may
/// move: such a scan defines the plane well, and a moved plane would gain whole polygons but lose distance.
/// \param base  the reach of the options
void weigh(std::vector<Unit>& units, double base);
/// Raises that cost for planes that were moved by far more than scans are off their planes.
void weigh_again(std::vector<Unit>& units);

/// Moves planes so that corners can lie on all their planes. Minimises the sum of area * mean square distance of the
/// scan from each plane and of the square steps of the corners, subject to each kept corner being on its planes.
/// \param kept  corners that are not kept for a unit, and units that do not bind, are left out
/// Source: Gauss-Newton with a quadratic penalty, in the planes alone: the place of least cost of each corner is known
///         for any planes (variable projection, Golub and Pereyra 1973). Each round solves one sparse system in three
///         unknowns a plane.
/// Cost: O(rounds * (corners + n^1.5)) for n planes.
void fit(std::vector<Unit>& units, const Places& places, const Kept& kept, const Schedule& schedule, const Job& job);

}  // namespace isimp::meshing::planar
