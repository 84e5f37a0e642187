#include "planar/near.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isimp::meshing::planar {
namespace {

// Source: own trials
constexpr double kOfMost = 0.8;    ///< share of the largest gap before: other vertices may be further off
constexpr double kAtMost = 1.05;   ///< share of the largest gap before
constexpr double kMore = 0.8;      ///< share of the reach of the options: a smaller increase is noise
constexpr double kMoreHeld = 0.4;  ///< share of the reach that is added to the distance of given planes
constexpr double kSlid = kMore;    ///< corners that moved less leave no such gap

}  // namespace

Near::Near(State& state, const Defects& defects, const std::vector<Unit>& units, const Around& around,
           const Places& places)
    : s_(state), f_(defects), units_(units), around_(around), places_(places) {
  for (std::int32_t c = 0; c < s_.corners.count(); ++c) {
    before_.push_back(gap(c));
    if (std::isfinite(before_[c])) most_gap_ = std::max(most_gap_, before_[c]);
  }
}

bool Near::is_on_scan(std::int32_t corner, const Vec3& x) {
  const auto& v = s_.mesh.vertices();
  if ((x - places_.start[corner]).norm() <= places_.base ||
      (x - v[s_.corners.vertex[corner]]).norm() <= s_.options.reach * places_.diagonal)
    return true;
  for (const Around::Use& use : around_.of(corner)) {
    std::vector<std::int32_t>& faces = faces_[units_[use.unit].chart];
    if (faces.empty()) faces = s_.labels.faces_of(units_[use.unit].chart);
    for (const std::int32_t f : faces) {
      const Triangle& t = s_.mesh.triangles()[f];
      if (distance_to(x, {v[t[0]], v[t[1]], v[t[2]]}) <= places_.base) return true;
    }
  }
  return false;
}

bool Near::is_covered(std::int32_t corner) const {
  if ((s_.corners.position[corner] - places_.start[corner]).norm() <= kSlid * places_.base) return true;
  const double g = gap(corner);
  const double more = kMore * places_.base;
  const double as_before = std::min(before_[corner] + more, kAtMost * most_gap_);
  return !std::isfinite(g) ||
         g <= std::max({kOfMost * most_gap_, as_before, from_held(corner) + kMoreHeld * places_.base});
}

/// The distance of a corner's vertex from the given planes: to the place where they meet, if they are perpendicular.
double Near::from_held(std::int32_t corner) const {
  const Vec3& home = s_.mesh.vertices()[s_.corners.vertex[corner]];
  double square = 0;
  for (const Around::Use& use : around_.of(corner)) {
    const Unit& u = units_[use.unit];
    if (u.held) square += std::pow(u.normal.dot(home) - u.offset, 2);
  }
  return std::sqrt(square);
}

/// The distance of a corner's vertex from the triangles that have the corner; infinite if the judge has none of them.
double Near::gap(std::int32_t corner) const {
  const Vec3& home = s_.mesh.vertices()[s_.corners.vertex[corner]];
  const auto& at = s_.corners.position;
  double least = std::numeric_limits<double>::infinity();
  for (const Around::Use& use : around_.of(corner))
    for (const Facet& f : f_.of(units_[use.unit].chart).facets.facets)
      if (std::find(f.corner.begin(), f.corner.end(), corner) != f.corner.end())
        least = std::min(least, distance_to(home, {at[f.corner[0]], at[f.corner[1]], at[f.corner[2]]}));
  return least;
}

}  // namespace isimp::meshing::planar
