#include "place/improve.h"

#include <span>
#include <vector>

#include "place/moves.h"

namespace isimp::meshing {
namespace {

constexpr double kLeast = 3e-3;  ///< work: share of the size of a chart: a shorter way is not worth a test

/// \param from_vertices  whether corners are placed from their vertices
void move_to_better(State& state, Defects& defects, std::span<const std::int32_t> corners, bool from_vertices,
                    Job& job) {
  const std::vector<Vec3> targets = state.better_places(corners, from_vertices);
  const double size = state.scale().size;
  std::vector<Move> moves;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if ((targets[i] - state.corners.position[corners[i]]).norm() >= kLeast * size)
      moves.push_back({corners[i], targets[i]});
  move_corners(state, defects, moves, job);
}

}  // namespace

void improve_places(State& state, Defects& defects, Job& job) {
  move_to_better(state, defects, state.take_stale(), true, job);
}

void settle_places(State& state, Defects& defects, Job& job) {
  std::vector<std::int32_t> corners;
  for (std::int32_t c = 0; c < state.corners.count(); ++c)
    if (!state.polygons.at(c).empty()) corners.push_back(c);
  move_to_better(state, defects, corners, false, job);
}

}  // namespace isimp::meshing
