#include "place/improve.h"

#include <vector>

#include "place/moves.h"

namespace isimp::meshing {
namespace {

constexpr double kLeast = 1e-6;  ///< share of the diagonal: no shorter way is worth a test

}  // namespace

void improve_places(State& state, Defects& defects, Job& job) {
  const std::vector<std::int32_t> corners = state.take_stale();
  const std::vector<Vec3> targets = state.better_places(corners);
  std::vector<Move> moves;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if ((targets[i] - state.corners.position[corners[i]]).norm() >= kLeast * state.mesh.diagonal())
      moves.push_back({corners[i], targets[i]});
  move_corners(state, defects, moves, job);
}

}  // namespace isimp::meshing
