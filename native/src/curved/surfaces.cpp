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
  double square = std::numeric_limits<double>::infinity(), at = 0;  ///< squared distance; share of the edge
  Vec2 away = Vec2::Zero();                                         ///< from that place to the point
  std::size_t edge = 0;
};

OnProfile nearest_on_profile(const CurvedSurface& s, const Vec2& p) {
  OnProfile best;
  const std::size_t n = corners(s), ends = s.closed ? n : n - 1;
  for (std::size_t i = 0; i < ends; ++i) {
    const Vec2 a = corner(s, i), t = corner(s, (i + 1) % n) - a;
    const double square = t.squaredNorm();
    // An open profile is extended straight at its ends, since its corners are means of points.
    const double from = !s.closed && i == 0 ? -kBeyond : 0, to = !s.closed && i + 1 == ends ? 1 + kBeyond : 1;
    const double u = square > 0 ? std::clamp((p - a).dot(t) / square, from, to) : 0.0;
    const Vec2 away = p - a - u * t;
    const double d = away.squaredNorm();
    if (d < best.square) best = {d, u, away, i};
  }
  return best;
}

Vec2 edge_of(const CurvedSurface& s, std::size_t i) { return corner(s, (i + 1) % corners(s)) - corner(s, i); }

double length_to(const CurvedSurface& s, const OnProfile& at) {
  double length = 0;
  for (std::size_t i = 0; i < at.edge; ++i) length += edge_of(s, i).norm();
  return length + at.at * edge_of(s, at.edge).norm();
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
  if (surface.kind == CurvedKind::extrusion) {
    const Vec3 up = surface.axis.cross(surface.across);
    return {v.dot(surface.across), v.dot(up), surface.across, up};
  }
  const double z = v.dot(surface.axis);
  const Vec3 out = v - z * surface.axis;
  const double rho = out.norm();
  return {rho, z, out / std::max(rho, kTiny), surface.axis};
}

Residual residual(const CurvedSurface& s, const Vec3& x) {
  if (s.kind == CurvedKind::plane) return {(x - s.point).dot(s.axis), s.axis};
  if (s.kind == CurvedKind::sphere) {
    const Vec3 v = x - s.point;
    const double l = std::max(v.norm(), kTiny);
    return {l - s.radius, s.side * v / l};
  }
  const Polar p = polar(s, x);
  if (has_profile(s)) {
    const OnProfile at = nearest_on_profile(s, {p.rho, p.z});
    const Vec2 edge = edge_of(s, at.edge), tangent = edge.squaredNorm() > 0 ? Vec2(edge.normalized()) : Vec2::UnitX();
    const Vec2 normal = s.side * Vec2(tangent.y(), -tangent.x());
    const bool is_inside = s.kind == CurvedKind::extrusion && at.away.dot(normal) < 0;
    return {is_inside ? -std::sqrt(at.square) : std::sqrt(at.square), normal.x() * p.out + normal.y() * p.up};
  }
  const double c = 1 / std::sqrt(1 + s.slope * s.slope);
  return {(p.rho - s.radius - s.slope * p.z) * c, s.side * c * (p.out - s.slope * s.axis)};
}

double along(const CurvedSurface& s, const Polar& p) {
  if (s.kind == CurvedKind::sphere) return std::atan2(p.rho, -p.z);
  if (has_profile(s)) return length_to(s, nearest_on_profile(s, {p.rho, p.z}));
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
