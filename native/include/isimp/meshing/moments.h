#pragma once

#include <array>

#include "isimp/core/types.h"

namespace isimp {

/// Integrals over a piece of surface. A face of a thinned mesh has the integrals over all faces that it stands for, so
/// that planes of regions are fitted to the whole scan (tiles/thin.h).
struct SurfaceMoments {
  double area = 0.0;
  Vec3 centre = Vec3::Zero();         ///< centre of gravity; arbitrary without area
  std::array<double, 6> second = {};  ///< xx, yx, yy, zx, zy, zz of the integral of (x - centre) (x - centre)^T

  /// Adds the moments of another piece.
  void add(const SurfaceMoments& other) {
    const double sum = area + other.area;
    if (!(sum > 0)) return;
    const Vec3 between = other.centre - centre;
    const double apart = area * other.area / sum;
    for (int i = 0, k = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j, ++k) second[k] += other.second[k] + apart * between[i] * between[j];
    centre += other.area / sum * between;
    area = sum;
  }
};

/// The moments of a triangle.
SurfaceMoments moments_of(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace isimp
