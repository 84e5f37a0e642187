// Planes fitted to the corners of polygons, for flat polygons.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "complex/planes.h"

namespace isimp::meshing {

/// Over-relaxation: a corner moves by this times the step to the mean of its projections; from 2 on it would diverge.
constexpr double kRelax = 1.7;
/// A corner may move by this times the length of its shortest edge.
constexpr double kOfEdge = 1.5;

/// The place nearest to `p` at most `radius` from `home`.
inline Vec3 within(const Vec3& p, const Vec3& home, double radius) {
  const Vec3 d = p - home;
  const double length = d.norm();
  return length > radius ? Vec3(home + d * (radius / length)) : p;
}

/// A plane fitted to the corners of a polygon, held near that of the chart: flat polygons could else settle anywhere,
/// and polygons on a bulge would drift inwards. If the corners do not fix a plane, the fit is the plane of the chart.
struct Fit {
  Vec3 normal, centre;
  bool fixed = false;

  void to(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Plane& plane);

 private:
  struct Spread;
  bool find_normal(const Spread& k, const Vec3& of_chart);
  bool refine(const Spread& k);
};

}  // namespace isimp::meshing
