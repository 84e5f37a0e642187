#include "place/ease.h"

#include "isimp/core/sorted.h"
#include "judge/trials.h"

namespace isimp::meshing {

void ease(State& state, Defects& defects, const Scope& scope, Job& job) {
  std::vector<std::int32_t> bent(state.complex.bent().begin(), state.complex.bent().end());
  sort_unique(bent);
  std::erase_if(bent, [&](std::int32_t v) {
    bool asked = false;
    for_each_leaving(state.mesh, v, [&](std::int32_t h) { asked = asked || scope.has(state.labels.label[h / 3]); });
    return !asked || !state.complex.is_corner(v);
  });
  turn_corners(state, defects, bent, job);
}

void turn_corners(State& state, Defects& defects, std::span<const std::int32_t> vertices, Job& job) {
  for (const std::int32_t v : vertices) {
    job.poll();
    attempt(state, defects, {}, kNone, [&] {
      if (state.complex.is_corner(v)) return state.drop_corner(v);
      state.add_corner(v);
      return true;
    });
  }
  defects.renew_hits();
}

}  // namespace isimp::meshing
