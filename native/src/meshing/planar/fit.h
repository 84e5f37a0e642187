#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// Which corners count for which units: by unit, by place in its loop.
using Kept = std::vector<std::vector<std::uint8_t>>;

/// How the penalty on corners off their planes grows from round to round.
struct Schedule {
  int rounds = 25;
  double from = 1, to = 1e6;
};

/// Sets what it costs to move each plane off its scan: more where the scan is nearer to a plane than corners may move, as
/// there the scan tells the plane, and what polygons gain is lost in distance.
/// \param base  the reach that is asked for
void weigh(std::vector<Unit>& units, double base);
/// Makes that dearer for the planes that were moved by far more than scans are off their planes.
void weigh_again(std::vector<Unit>& units);

/// Moves planes so that corners can lie on all planes round them: the least sum of area * mean square distance of the scan
/// from each plane and of the square steps of the corners, subject to each kept corner being on its planes.
/// \param kept  what asks nothing of each other is left out, and so are units that do not bind
/// Source: Gauss-Newton with a quadratic penalty, in the planes alone: each corner is where it costs least, which is known
///         for any planes (variable projection, Golub and Pereyra 1973). One sparse system in three unknowns a plane is
///         solved in each round.
/// Cost: O(rounds * (corners + n^1.5)) for n planes.
void fit(std::vector<Unit>& units, const Places& places, const Kept& kept, const Schedule& schedule, const Job& job);

}  // namespace isimp::meshing::planar
