#include "place/moves.h"

#include <array>
#include <vector>

namespace isimp::meshing {
namespace {

constexpr std::array kShares{1.0, 0.5, 0.2};  ///< shares of a way; the first accepted one is used
constexpr std::size_t kCornersAPoll = 64;     ///< work: corners from one poll to the next

/// Moves corners to the given places, and returns the moves back.
std::vector<Move> carry_out(State& state, std::span<const Move> moves) {
  std::vector<Move> back;
  back.reserve(moves.size());
  for (const Move& m : moves) {
    back.push_back({m.corner, state.corners.position[m.corner]});
    state.move(m.corner, m.to);
  }
  return back;
}

std::vector<std::int32_t> charts_at(const State& state, std::span<const Move> moves) {
  std::vector<std::int32_t> corners;
  for (const Move& m : moves) corners.push_back(m.corner);
  return state.polygons.charts_at(corners);
}

bool move_all(State& state, Defects& defects, std::span<const Move> moves) {
  const std::vector<bool> before = defects.defective();
  const std::vector<std::int32_t> charts = charts_at(state, moves);
  defects.keep();
  const std::vector<Move> back = carry_out(state, moves);
  defects.judge(charts);
  const std::vector<bool> after = defects.defective();
  bool sound = true;
  for (std::size_t l = 0; l < after.size() && sound; ++l) sound = !after[l] || before[l];
  if (sound) return true;
  carry_out(state, back);
  defects.judge(charts);
  return false;
}

}  // namespace

bool attempt_moves(State& state, Defects& defects, std::span<const Move> moves) {
  const std::vector<Move> back = carry_out(state, moves);
  if (defects.accepts(charts_at(state, moves))) return true;
  carry_out(state, back);
  return false;
}

void move_corners(State& state, Defects& defects, std::span<const Move> moves, Job& job) {
  if (moves.empty() || move_all(state, defects, moves)) return;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    if (i % kCornersAPoll == 0) job.poll();
    const std::int32_t c = moves[i].corner;
    const Vec3 from = state.corners.position[c];
    for (const double share : kShares) {
      const Move some{c, from + share * (moves[i].to - from)};
      if (attempt_moves(state, defects, {&some, 1})) break;
    }
  }
  defects.renew_hits();
}

}  // namespace isimp::meshing
