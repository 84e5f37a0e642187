#include "complex/angles.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace isimp::meshing {

double angle_at(const Vec3& from, const Vec3& p, const Vec3& to, const Vec3& normal) {
  const auto flat = [&](const Vec3& d) { return Vec3(d - normal.dot(d) * normal); };
  const Vec3 in = flat(p - from), out = flat(to - p);
  const double turn = std::atan2(normal.dot(in.cross(out)), in.dot(out));
  return 180 - turn * 180 / std::numbers::pi;
}

Angles angles_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Vec3& normal) {
  Angles result;
  const auto n = polygon.size();
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& p = position[polygon[i]];
    const Vec3 &from = position[polygon[i > 0 ? i - 1 : n - 1]], &to = position[polygon[i + 1 < n ? i + 1 : 0]];
    const double angle = angle_at(from, p, to, normal);
    result.least = std::min(result.least, angle);
    result.reflex += angle > kReflex;
    result.excess += std::max(0.0, angle - kReflex);
    result.lack += std::max(0.0, kNeedle - angle);
    area += p.cross(to);
  }
  result.faces_away = !(area.dot(normal) > 0);
  return result;
}

}  // namespace isimp::meshing
