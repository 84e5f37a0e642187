// Joins charts and junctions, and undoes joins that spoil polygons.
#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"

namespace isimp::meshing {

/// Two junctions that were made one.
struct Join {
  std::int32_t giver, taker;         ///< charts
  std::int32_t gone;                 ///< vertex that is no junction any more
  std::vector<std::int32_t> faces;   ///< faces moved from the giver to the taker
  std::vector<std::int32_t> charts;  ///< all that meet in the junction
};

/// Whether two charts face different directions, and one of them is the wall of a hole or, in a perforated mesh, may be
/// one.
bool parts_wall(const State& state, std::int32_t a, std::int32_t b);

/// Whether the partition's locks, barriers and bound let faces go from one chart to another, and no wall is lost.
/// \param faces  in ascending order
/// Cost: O(faces).
bool may_give(const State& state, std::int32_t giver, std::int32_t taker, const std::vector<std::int32_t>& faces);

/// Undoes the joins at defective charts, and all joins on top of these. `update` must follow.
/// \param defective  by chart
/// \param joins   the undone joins are removed
/// \return whether there were any
/// Cost: O(faces that the joins moved).
bool take_back(State& state, const std::vector<bool>& defective, std::vector<Join>& joins);

}  // namespace isimp::meshing
