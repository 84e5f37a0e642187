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

/// Moves planes and corners together so that corners lie on their planes: the least sum of area * mean square distance
/// of the scan from each plane and of the square steps of the corners, subject to each kept corner being on its planes.
/// \param kept  what asks nothing of each other is left out
/// \param at  (C) the corners, from where they are
/// Source: Gauss-Newton with a quadratic penalty; corners are eliminated as points are in bundle adjustment (Triggs et
///         al. 2000), so one sparse system in three unknowns a plane is solved in each round.
/// Cost: O(rounds * (corners + n^1.5)) for n planes.
void fit(std::vector<Unit>& units, const Places& places, const Kept& kept, const Schedule& schedule,
         std::vector<Vec3>& at, const Job& job);

}  // namespace isimp::meshing::planar
