#include "complex/outline.h"

#include <Eigen/Geometry>

namespace isimp::meshing {

std::vector<Vec3> areas_beyond_chords(const State& state, std::int32_t chart) {
  const auto loop = state.complex.loop(chart);
  const auto chords = state.complex.chords(chart);
  const auto at = [&](std::int32_t h) -> const Vec3& { return state.mesh.vertices()[state.mesh.from(h)]; };
  std::vector<Vec3> areas(chords.size(), Vec3::Zero());
  if (chords.empty()) return areas;
  std::size_t place = 0;
  while (loop[place] != chords[0]) ++place;
  for (std::size_t k = 0; k < chords.size(); ++k) {
    const Vec3& origin = at(chords[k]);
    const std::int32_t end = chords[k + 1 < chords.size() ? k + 1 : 0];
    Vec3 before = Vec3::Zero();
    for (std::size_t n = 0; n < loop.size() && (n == 0 || loop[place] != end); ++n) {
      place = place + 1 < loop.size() ? place + 1 : 0;
      const Vec3 here = at(loop[place]) - origin;
      areas[k] += before.cross(here) / 2;
      before = here;
    }
  }
  return areas;
}

std::vector<std::int32_t> chords_of(const State& state, std::int32_t chart, std::span<const std::int32_t> polygon) {
  const auto chords = state.complex.chords(chart);
  const auto n = chords.size();
  std::vector<std::int32_t> found(polygon.size(), kNone);
  const auto at = [&](std::int32_t h) { return state.corners.of_vertex[state.mesh.from(h)]; };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::int32_t from = polygon[i], to = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    for (std::size_t k = 0; k < n && found[i] == kNone; ++k)
      if (at(chords[k]) == from && at(chords[k + 1 < n ? k + 1 : 0]) == to) found[i] = static_cast<std::int32_t>(k);
  }
  return found;
}

Vec3 direction_on_scan(const State& state, std::int32_t chart, std::span<const std::int32_t> polygon,
                       std::span<const Vec3> beyond_chords) {
  std::vector<Vec3> home;
  std::vector<std::int32_t> order;
  for (const std::int32_t c : polygon) {
    order.push_back(static_cast<std::int32_t>(home.size()));
    home.push_back(state.mesh.vertices()[state.corners.vertex[c]]);
  }
  Vec3 area = vector_area(order, home);
  double extent = 0;
  for (const Vec3& x : home) extent = std::max(extent, (x - home[0]).norm());
  for (const std::int32_t k : chords_of(state, chart, polygon))
    if (k != kNone) area += beyond_chords[k];
  const double size = area.norm();
  return size > kThickness * state.mesh.diagonal() * extent ? Vec3(area / size) : state.planes[chart].normal;
}

}  // namespace isimp::meshing
