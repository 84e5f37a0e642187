#include "planar/unit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "complex/outline.h"
#include "isimp/core/sorted.h"
#include "isimp/core/symmetric.h"

namespace isimp::meshing::planar {
namespace {

// tuned planar
constexpr double kMoveOfEdge = 0.5;  ///< largest move of a corner, as a share of its shortest edge
constexpr double kLeast = 0.3;       ///< largest move of a corner at the least, as a share of the reach of the options
constexpr double kMostMove = 1.5;    ///< largest move of a corner at the most, as a share of the reach of the options
constexpr double kMostToHeld = 6;    ///< replaces kMostMove if given planes are further off
/// A spread whose smallest eigenvalue is above this share of the next fixes no plane.
constexpr double kThin = 0.25;

/// Sets the plane that fits the scan best, or the plane of the corners if the scan is too thin a strip to define one.
void find_plane(Unit& unit, std::span<const Vec3> at, double least_area) {
  const Vec3 outline = vector_area(unit.loop, at);
  Vec3 middle = Vec3::Zero();
  for (const std::int32_t c : unit.loop) middle += at[c];
  middle /= static_cast<double>(unit.loop.size());
  Plane& scan = unit.scan;
  const double length = outline.norm();
  if (scan.area <= least_area && !scan.held) {
    scan.area = std::max(length, least_area);
    scan.centre = middle;
    scan.spread.setZero();
    for (const std::int32_t c : unit.loop)
      scan.spread += (at[c] - middle) * (at[c] - middle).transpose() / static_cast<double>(unit.loop.size());
    if (length > 0) scan.normal = outline / length;
  }
  const auto [values, vectors] = spectrum_of(scan.spread);
  unit.noise = std::sqrt(std::max(values[0], 0.0));
  unit.held = scan.held;
  if (scan.held) {
    unit.normal = scan.normal;
    unit.offset = scan.normal.dot(scan.centre);
    return;
  }
  Vec3 n = vectors.col(0);
  const bool is_thin = !(values[0] <= kThin * values[1]);
  if (is_thin) n = length > 0 ? Vec3(outline / length) : scan.normal;
  if (n.dot(length > 0 ? outline : scan.normal) < 0) n = -n;
  unit.normal = n;
  unit.offset = n.dot(scan.centre);
}

}  // namespace

bool Places::allows(std::int32_t corner, const Vec3& x) const { return (x - start[corner]).norm() <= reach[corner]; }

void Places::limit(std::span<const Unit> units) {
  std::vector<double> to_held(start.size(), 0);  // sum of the distances of a corner from its given planes
  for (const Unit& u : units)
    if (u.held)
      for (const std::int32_t c : u.loop) to_held[c] += std::abs(u.normal.dot(start[c]) - u.offset);
  for (std::size_t c = 0; c < reach.size(); ++c)
    reach.edit(c) =
        std::min(reach[c], std::max(kMostMove * base, std::min(to_held[c] + kMoveOfEdge * base, kMostToHeld * base)));
}

bool is_flat(std::span<const std::int32_t> polygon, std::span<const Vec3> at, double diagonal) {
  if (polygon.size() == 3) return true;
  if (bend_of(polygon, at) > kThickness * diagonal) return false;
  std::vector<Vec3> rounded;
  for (const std::int32_t c : polygon) rounded.push_back(rounded_to_float(at[c]));
  return bend_of(numbers_below(static_cast<std::int32_t>(polygon.size())), rounded) <= kThickness * diagonal;
}

std::vector<Unit> units_of(const State& state) {
  std::vector<Unit> units;
  double area = 0;
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
    if (state.polygons.count_of(l) == 0) continue;
    const std::vector<Vec3> beyond = areas_beyond_chords(state, l);
    const auto loop = state.polygons.of(state.polygons.first_of(l));
    Unit& u = units.emplace_back();
    u.chart = l;
    u.loop.assign(loop.begin(), loop.end());
    for (const std::int32_t c : u.loop) u.home.push_back(state.mesh.vertices()[state.corners.vertex[c]]);
    for (const std::int32_t k : chords_of(state, l, u.loop)) u.beyond.push_back(k == kNone ? Vec3::Zero() : beyond[k]);
    u.scan = state.planes[l];
    hold(u.scan, state.partition, state.labels.charts[l].region, state.mesh.origin());
    area += u.scan.area;
  }
  const double least = 1e-9 * area / static_cast<double>(std::max<std::size_t>(units.size(), 1));
  for (Unit& u : units) find_plane(u, state.corners.position, least);
  return units;
}

Places places_of(const State& state, const std::vector<Unit>& units, double base) {
  Places p;
  p.start = state.corners.position;
  p.base = base;
  p.diagonal = state.mesh.diagonal();
  std::vector<double> most(p.start.size(), std::numeric_limits<double>::infinity());
  for (const Unit& u : units)
    for (std::size_t i = 0; i < u.loop.size(); ++i) {
      const std::int32_t a = u.loop[i], b = u.loop[i + 1 < u.loop.size() ? i + 1 : 0];
      const double length = (p.start[a] - p.start[b]).norm();
      for (const std::int32_t c : {a, b}) most[c] = std::min(most[c], length);
    }
  for (double& reach : most) reach = std::max(kMoveOfEdge * reach, kLeast * base);
  p.reach.assign(std::move(most));
  p.limit(units);
  return p;
}

}  // namespace isimp::meshing::planar
