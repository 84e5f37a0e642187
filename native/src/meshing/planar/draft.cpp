#include "planar/draft.h"

#include <algorithm>

#include "planar/fit.h"

namespace isimp::meshing::planar {
namespace {

std::vector<std::int32_t> first_units(const std::vector<Unit>& units, std::size_t charts) {
  std::vector<std::int32_t> first(charts + 1, 0);
  for (const Unit& u : units) ++first[u.chart + 1];
  for (std::size_t l = 1; l < first.size(); ++l) first[l] += first[l - 1];
  return first;
}

}  // namespace

std::vector<std::int32_t> Waiting::take() {
  for (const std::int32_t i : some_) has_[i] = false;
  std::sort(some_.begin(), some_.end());
  return std::exchange(some_, {});
}

Draft::Draft(const State& state)
    : units(units_of(state)),
      first(first_units(units, state.labels.charts.size())),
      places(places_of(state, units, state.options.planar_reach * state.mesh.diagonal())),
      around(units, state.corners.count()),
      at(places.start),
      moving(state.corners.count()),
      dirty(units.size()) {
  for (const Unit& u : units) kept.emplace_back(u.loop.size(), 0);
  for (std::int32_t c = 0; c < state.corners.count(); ++c) moving.add(c);
  weigh(units, places.base);
}

void Draft::place(State& state, const Job& job) {
  const std::vector<std::int32_t> corners = moving.take();
  const auto n = static_cast<std::int32_t>(corners.size());
  std::vector<Vec3> to(corners.size());
  state.threads.blocks(n, kBlock, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    job.poll();
    for (std::int32_t i = begin; i < end; ++i) to[i] = meet(corners[i]);
  });
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t c = corners[i];
    at[c] = to[i];
    state.move(c, to[i]);
    for (const auto& [u, place] : around.of(c)) dirty.add(u);
  }
}

void Draft::lower(std::int32_t corner, double reach) {
  places.reach[corner] = std::min(places.reach[corner], reach);
  moving.add(corner);
}

void Draft::ask(std::int32_t unit) {
  for (const std::int32_t c : units[unit].loop) moving.add(c);
  dirty.add(unit);
}

}  // namespace isimp::meshing::planar
