#pragma once

#include <Eigen/Geometry>
#include <limits>

#include "isimp/core/types.h"

namespace isimp::detail {

/// A point of a triangle: the weights of corners 1 and 2, and the square of its distance.
struct Place {
  double squared = std::numeric_limits<double>::infinity(), b = 0, c = 0;
};

/// The closest point of a triangle a, a + u, a + v (Ericson, Real-Time Collision Detection, 5.1.5).
inline Place closest_on(const Vec3& p, const Vec3& a, const Vec3& u, const Vec3& v) {
  const Vec3 ap = p - a;
  const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm();
  const double d1 = u.dot(ap), d2 = v.dot(ap), d3 = d1 - uu, d4 = d2 - uv, d5 = d1 - uv, d6 = d2 - vv;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  Place place;
  if (d1 <= 0 && d2 <= 0) {
  } else if (d3 >= 0 && d4 <= d3) {
    place.b = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    place.b = d1 / (d1 - d3);
  } else if (d6 >= 0 && d5 <= d6) {
    place.c = 1;
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    place.c = d2 / (d2 - d6);
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    place.c = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    place.b = 1 - place.c;
  } else if (const double sum = va + vb + vc; sum > 0) {
    place.b = vb / sum;
    place.c = vc / sum;
  }
  place.squared = (ap - place.b * u - place.c * v).squaredNorm();
  return place;
}

}  // namespace isimp::detail
