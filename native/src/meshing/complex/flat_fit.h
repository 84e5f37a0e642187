// Planes fitted to the corners of polygons, for flat polygons.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "complex/planes.h"

namespace isimp::meshing {

/// tuned places: weight of the mean square distance of a polygon's corners from its plane (placement.h), where that of its
/// chart weighs 1.
constexpr double kOfBend = 6;
constexpr double kOfTie = 2;  ///< tuned places: square distance of a corner from its first place, in areas of a vertex

// tuned shapes
/// A corner may move by this times the length of its shortest edge.
constexpr double kOfEdge = 1.5;

/// The place nearest to `p` at most `radius` from `home`.
inline Vec3 within(const Vec3& p, const Vec3& home, double radius) {
  const Vec3 d = p - home;
  const double length = d.norm();
  return length > radius ? Vec3(home + d * (radius / length)) : p;
}

/// The plane of a polygon of least energy for given places of its corners: near both these and its chart. A held plane
/// is given. If corners and chart fix no plane, it is that of the chart.
struct Fit {
  Vec3 normal, centre;
  bool fixed = false;

  /// \param bend  weight of the corners
  void to(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Plane& plane, double bend);

 private:
  struct Spread;
  bool find_normal(const Spread& k, const Vec3& of_chart);
  bool refine(const Spread& k);
};

}  // namespace isimp::meshing
