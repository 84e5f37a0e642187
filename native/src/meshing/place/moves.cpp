#include "place/moves.h"

#include <array>
#include <vector>

#include "judge/trials.h"

namespace isimp::meshing {
namespace {

// tuned unrecorded
constexpr std::array kShares{1.0, 0.5, 0.2};  ///< shares of a way; the first accepted one is used
constexpr std::size_t kCornersAPoll = 64;     ///< work: corners from one poll to the next

bool move_all(State& state, Defects& defects, std::span<const Move> moves) {
  const std::vector<bool> before = defects.defective();
  defects.keep();
  Transaction transaction(state);
  std::vector<std::int32_t> corners;
  for (const Move& m : moves) {
    corners.push_back(m.corner);
    state.move(m.corner, m.to);
  }
  const std::vector<std::int32_t> charts = state.polygons.charts_at(corners);
  defects.judge(charts);
  const std::vector<bool> after = defects.defective();
  bool sound = true;
  for (std::size_t l = 0; l < after.size() && sound; ++l) sound = !after[l] || before[l];
  if (sound) {
    transaction.commit();
  } else {
    transaction.rollback();
    defects.judge(charts);
  }
  return sound;
}

}  // namespace

void move_corners(State& state, Defects& defects, std::span<const Move> moves, Job& job) {
  if (moves.empty() || move_all(state, defects, moves)) return;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    if (i % kCornersAPoll == 0) job.poll();
    const std::int32_t c = moves[i].corner;
    const Vec3 from = state.corners.position[c];
    const std::vector<std::int32_t> charts = state.polygons.charts_at({&c, 1});
    for (const double share : kShares) {
      const auto move = [&] {
        state.move(c, from + share * (moves[i].to - from));
        return true;
      };
      if (attempt(state, defects, charts, kNone, move, Places::moved)) break;
    }
  }
  defects.renew_hits();
}

}  // namespace isimp::meshing
