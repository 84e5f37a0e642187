#include "place/improve.h"

#include <array>
#include <vector>

#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr std::array kShares{1.0, 0.5, 0.2};  ///< shares of the way to the target; the first accepted one is used
constexpr double kLeast = 1e-6;               ///< share of the diagonal: no shorter way is worth a test
constexpr std::size_t kStride = 64;           ///< corners from one poll to the next

/// Moves a corner towards a place as far as its polygons stay sound.
void move_towards(State& s, Findings& findings, std::int32_t corner, const Vec3& target) {
  std::vector<std::int32_t> pieces;
  for (const std::int32_t q : s.polygons.at(corner)) pieces.push_back(s.polygons.piece(q));
  sort_unique(pieces);
  const Vec3 from = s.corners.position[corner];
  for (const double share : kShares) {
    s.move(corner, from + share * (target - from));
    if (findings.accepts(pieces, corner)) return;
  }
  s.move(corner, from);
}

}  // namespace

void improve_places(State& state, Findings& findings, Job& job) {
  const std::vector<std::int32_t> corners = state.take_stale();
  const std::vector<Vec3> targets = state.better_places(corners);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i % kStride == 0) job.poll();
    if ((targets[i] - state.corners.position[corners[i]]).norm() >= kLeast * state.mesh.diagonal())
      move_towards(state, findings, corners[i], targets[i]);
  }
  findings.renew_hits();
}

}  // namespace isimp::meshing
