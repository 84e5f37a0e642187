#include "planar/draft.h"

#include <algorithm>

#include "planar/fit.h"
#include "planar/solve.h"

namespace isimp::meshing::planar {

std::vector<std::int32_t> Waiting::take() {
  for (const std::int32_t i : some_) has_[i] = false;
  std::sort(some_.begin(), some_.end());
  return std::exchange(some_, {});
}

Draft::Draft(State& s, const Job& job)
    : state(s), unit_of(s.labels.charts.size(), kNone), beyond(s.corners.count()), moving(s.corners.count()) {
  std::vector<Unit> all = units_of(s);
  places = places_of(s, all, s.options.planar_reach * s.mesh.diagonal());
  around = Around(all, s.corners.count());
  weigh(all, places.base);
  solve(all, around, places, s.threads, job);
  for (std::size_t u = 0; u < all.size(); ++u) {
    const std::vector<std::int32_t>& loop = all[u].loop;
    unit_of[all[u].chart] = static_cast<std::int32_t>(u);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto [a, b] = std::minmax(loop[i], loop[(i + 1) % loop.size()]);
      beyond.edit(a).push_back(b);
    }
  }
  for (std::int32_t c = 0; c < s.corners.count(); ++c) moving.add(c);
  dirty = Waiting(all.size());
  units.assign(std::move(all));
}

void Draft::place(const Job& job) {
  const std::vector<std::int32_t> corners = moving.take();
  const auto n = static_cast<std::int32_t>(corners.size());
  std::vector<Vec3> to(corners.size());
  state.threads.blocks(n, kBlock, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    job.poll();
    for (std::int32_t i = begin; i < end; ++i) to[i] = meet(corners[i]);
  });
  for (std::int32_t i = 0; i < n; ++i) {
    state.move(corners[i], to[i]);
    for (const auto& [u, place] : around.of(corners[i])) dirty.add(u);
  }
}

void Draft::lower(std::int32_t corner, double reach) {
  places.reach.edit(corner) = std::min(places.reach[corner], reach);
  moving.add(corner);
}

void Draft::ask(std::int32_t unit) {
  for (const std::int32_t c : units[unit].loop) moving.add(c);
  dirty.add(unit);
}

}  // namespace isimp::meshing::planar
