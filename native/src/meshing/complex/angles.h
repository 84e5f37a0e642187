#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "isimp/core/types.h"

namespace isimp::meshing {

// tuned needles
constexpr double kReflex = 190;  ///< degrees: from here on a corner counts as reflex

constexpr double kNeedle = 20;  ///< degrees: below, a corner is sharp
/// The cosine of about kNeedle: a triangle with a sharper corner is a needle.
constexpr double kSharpCosine = 0.94;

/// Measures of the corner angles of some polygons, in degrees.
struct Angles {
  double least = 360;
  double excess = 0, lack = 0;  ///< sums over all corners: degrees above kReflex, and degrees missing to kNeedle
  int reflex = 0;
  bool faces_away = false;  ///< from the normal

  void add(const Angles& o) {
    least = std::min(least, o.least);
    excess += o.excess;
    lack += o.lack;
    reflex += o.reflex;
    faces_away |= o.faces_away;
  }
};

/// The angle at corner `p` of a polygon between its neighbours `from` and `to`, seen along a normal; degrees.
double angle_at(const Vec3& from, const Vec3& p, const Vec3& to, const Vec3& normal);

/// The measures of one polygon, seen along a normal.
Angles angles_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Vec3& normal);

}  // namespace isimp::meshing
