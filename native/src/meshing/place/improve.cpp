#include "place/improve.h"

#include <vector>

#include "place/moves.h"

namespace isimp::meshing {
namespace {

constexpr double kLeast = 3e-3;  ///< share of the size of a chart: a shorter way is not worth a test

}  // namespace

void improve_places(State& state, Defects& defects, Job& job) {
  const std::vector<std::int32_t> corners = state.take_stale();
  const std::vector<Vec3> targets = state.better_places(corners);
  const double size = state.scale().size;
  std::vector<Move> moves;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if ((targets[i] - state.corners.position[corners[i]]).norm() >= kLeast * size)
      moves.push_back({corners[i], targets[i]});
  move_corners(state, defects, moves, job);
}

}  // namespace isimp::meshing
