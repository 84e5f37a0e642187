#include "surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace isimp::curved {
namespace {

constexpr double kTiny = 1e-300;
constexpr double kBeyond = 3;  ///< times its first and its last edge: an open profile is extended by this

/// The place on a profile that is nearest to a point.
struct OnProfile {
  double distance = std::numeric_limits<double>::infinity(), length = 0;
  Vec2 tangent = Vec2::UnitX();
};

OnProfile nearest_on_profile(const CurvedSurface& s, const Vec2& p) {
  OnProfile best;
  double before = 0, least = std::numeric_limits<double>::infinity();
  const std::size_t n = corners(s), ends = s.closed ? n : n - 1;
  for (std::size_t i = 0; i < ends; ++i) {
    const Vec2 a = corner(s, i), t = corner(s, (i + 1) % n) - a;
    const double length = t.norm();
    // An open profile is extended straight at its ends, since its corners are means of points.
    const double from = !s.closed && i == 0 ? -kBeyond : 0, to = !s.closed && i + 1 == ends ? 1 + kBeyond : 1;
    const double u = length > 0 ? std::clamp((p - a).dot(t) / (length * length), from, to) : 0.0;
    const double d = (p - a - u * t).squaredNorm();
    if (d < least) {
      least = d;
      best = {std::sqrt(d), before + u * length, length > 0 ? Vec2(t / length) : Vec2(Vec2::UnitX())};
    }
    before += length;
  }
  return best;
}

}  // namespace

std::array<Vec3, 2> frame(const Vec3& axis) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vec3 u = axis.cross(Vec3::Unit(least)).normalized();
  return {u, axis.cross(u)};
}

Polar polar(const CurvedSurface& surface, const Vec3& p) {
  const Vec3 v = p - surface.point;
  const double z = v.dot(surface.axis);
  const Vec3 out = v - z * surface.axis;
  const double rho = out.norm();
  return {rho, z, out / std::max(rho, kTiny)};
}

Residual residual(const CurvedSurface& s, const Vec3& x) {
  if (s.kind == CurvedKind::plane) return {(x - s.point).dot(s.axis), s.axis};
  if (s.kind == CurvedKind::sphere) {
    const Vec3 v = x - s.point;
    const double l = std::max(v.norm(), kTiny);
    return {l - s.radius, s.side * v / l};
  }
  const Polar p = polar(s, x);
  if (s.kind == CurvedKind::revolution) {
    const OnProfile at = nearest_on_profile(s, {p.rho, p.z});
    return {at.distance, s.side * (at.tangent.y() * p.out - at.tangent.x() * s.axis)};
  }
  const double c = 1 / std::sqrt(1 + s.slope * s.slope);
  return {(p.rho - s.radius - s.slope * p.z) * c, s.side * c * (p.out - s.slope * s.axis)};
}

double along(const CurvedSurface& s, const Polar& p) {
  if (s.kind == CurvedKind::sphere) return std::atan2(p.rho, -p.z);
  if (s.kind == CurvedKind::revolution) return nearest_on_profile(s, {p.rho, p.z}).length;
  return p.z;
}

double angle(const CurvedProxy& proxy, const Vec3& p) {
  const Vec3 v = p - proxy.point;
  const double a = std::atan2(v.dot(proxy.axis.cross(proxy.across)), v.dot(proxy.across));
  return a < 0 ? a + kTurn : a;
}

double turned(double angle) {
  const double a = std::fmod(angle + std::numbers::pi, kTurn);
  return (a < 0 ? a + kTurn : a) - std::numbers::pi;
}

}  // namespace isimp::curved
