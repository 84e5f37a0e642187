#include "fit/surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr double kBeyond = 3;        ///< extension of an open profile at both ends, in lengths of its end edges
constexpr std::size_t kBlock = 8;    ///< work: number of edges of a profile that are searched at once
constexpr double kRounding = 1e-12;  ///< rounding: of a squared distance, over the largest square of its terms

}  // namespace

std::array<Vec3, 2> frame(const Vec3& axis) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vec3 u = axis.cross(Vec3::Unit(least)).normalized();
  return {u, axis.cross(u)};
}

Locator::Locator(const CurvedSurface& s) : surface_(&s) {
  if (!has_profile(s)) return;
  const std::size_t n = corners(s), ends = s.closed ? n : n - 1;
  double length = 0;
  for (std::size_t i = 0; i < ends; ++i) {
    const Vec2 a = corner(s, i), t = corner(s, (i + 1) % n) - a;
    const double square = t.squaredNorm();
    x_.push_back(a.x());
    y_.push_back(a.y());
    dx_.push_back(t.x());
    dy_.push_back(t.y());
    inverse_.push_back(square > 0 ? 1 / square : 0);
    // An open profile is extended straight at its ends, since its corners are means of points.
    from_.push_back(!s.closed && i == 0 ? -kBeyond : 0);
    to_.push_back(!s.closed && i + 1 == ends ? 1 + kBeyond : 1);
    length_.push_back(length);
    length += std::sqrt(square);
    if (i % kBlock == 0) block_.push_back({Vec2::Constant(kNever), Vec2::Constant(-kNever), i, i});
    Block& b = block_.back();
    ++b.end;
    for (const double u : {from_.back(), to_.back()}) {
      const Vec2 end = a + u * t;
      b.low = b.low.cwiseMin(end);
      b.high = b.high.cwiseMax(end);
      size_ = std::max(size_, end.squaredNorm());
    }
  }
}

Locator::OnProfile Locator::nearest(double x, double y) const {
  double least = kNever;
  std::size_t best = 0;
  // An edge further than the nearest by rounding alone may still be the one: of equal ones it has the lowest number.
  const double rounding = kRounding * (size_ + x * x + y * y);
  const auto search = [&](const Block& b) {
    std::array<double, kBlock> square;
    const std::size_t count = b.end - b.begin;
    for (std::size_t k = 0; k < count; ++k) {  // without a branch, so that compilers use vectors
      const std::size_t i = b.begin + k;
      const double px = x - x_[i], py = y - y_[i];
      const double u = std::min(std::max((px * dx_[i] + py * dy_[i]) * inverse_[i], from_[i]), to_[i]);
      const double ax = px - u * dx_[i], ay = py - u * dy_[i];
      square[k] = ax * ax + ay * ay;
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (square[k] > least || (square[k] == least && b.begin + k >= best)) continue;
      least = square[k];
      best = b.begin + k;
    }
  };
  const auto bound = [&](const Block& b) {
    const double dx = std::max(std::max(b.low.x() - x, x - b.high.x()), 0.0);
    const double dy = std::max(std::max(b.low.y() - y, y - b.high.y()), 0.0);
    return dx * dx + dy * dy;
  };
  double nearest = kNever;
  const Block* first = nullptr;
  for (const Block& b : block_) {
    const double square = bound(b);
    if (square >= nearest) continue;
    nearest = square;
    first = &b;
  }
  if (first != nullptr) search(*first);
  for (const Block& b : block_)
    if (&b != first && bound(b) <= least + rounding) search(b);
  const double px = x - x_[best], py = y - y_[best];
  const double u = std::clamp((px * dx_[best] + py * dy_[best]) * inverse_[best], from_[best], to_[best]);
  return {best, u, {px - u * dx_[best], py - u * dy_[best]}};
}

double Locator::length_to(const OnProfile& on) const {
  return length_[on.edge] + on.share * std::hypot(dx_[on.edge], dy_[on.edge]);
}

double Locator::along(const Polar& p) const {
  if (surface_->kind == CurvedKind::sphere) return std::atan2(p.rho, -p.z);
  return has_profile(*surface_) ? length_to(nearest(p.rho, p.z)) : p.z;
}

Vec2 Locator::place(double along) const {
  if (!has_profile(*surface_)) return surface_->radius * Vec2(std::sin(along), -std::cos(along));
  const auto after = std::upper_bound(length_.begin() + 1, length_.end(), along);
  const auto i = static_cast<std::size_t>(after - length_.begin() - 1);
  const double length = std::hypot(dx_[i], dy_[i]);
  const double share = length > 0 ? (along - length_[i]) / length : 0;
  return {x_[i] + share * dx_[i], y_[i] + share * dy_[i]};
}

OnSurface Locator::at(const Vec3& x) const {
  const CurvedSurface& s = *surface_;
  if (s.kind == CurvedKind::plane) return {{}, residual(x), 0};
  const Polar p = polar(s, x);
  if (has_profile(s)) {
    const OnProfile on = nearest(p.rho, p.z);
    return {p, residual(p, on), length_to(on)};
  }
  if (s.kind == CurvedKind::sphere) return {p, residual(x), std::atan2(p.rho, -p.z)};
  return {p, residual(p), p.z};
}

Residual Locator::residual(const Vec3& x) const {
  const CurvedSurface& s = *surface_;
  if (s.kind == CurvedKind::plane) return {(x - s.point).dot(s.axis), s.axis};
  if (s.kind == CurvedKind::sphere) {
    const Vec3 v = x - s.point;
    const double l = std::max(v.norm(), kTiny);
    return {l - s.radius, s.side * v / l};
  }
  const Polar p = polar(s, x);
  return has_profile(s) ? residual(p, nearest(p.rho, p.z)) : residual(p);
}

Residual Locator::residual(const Polar& p) const {
  const CurvedSurface& s = *surface_;
  const double c = 1 / std::sqrt(1 + s.slope * s.slope);
  return {(p.rho - s.radius - s.slope * p.z) * c, s.side * c * (p.out - s.slope * s.axis)};
}

Residual Locator::residual(const Polar& p, const OnProfile& on) const {
  const CurvedSurface& s = *surface_;
  const Vec2 edge(dx_[on.edge], dy_[on.edge]);
  const Vec2 tangent = edge.squaredNorm() > 0 ? Vec2(edge.normalized()) : Vec2::UnitX();
  const Vec2 normal = s.side * Vec2(tangent.y(), -tangent.x());
  const bool is_inside = s.kind == CurvedKind::extrusion && on.away.dot(normal) < 0;
  const double distance = on.away.norm();
  return {is_inside ? -distance : distance, normal.x() * p.out + normal.y() * p.up};
}

double Locator::distance(const Vec3& x) const {
  if (!has_profile(*surface_)) return std::abs(residual(x).distance);
  const Polar p = polar(*surface_, x);
  return nearest(p.rho, p.z).away.norm();
}

double angle(const CurvedProxy& proxy, const Vec3& p) {
  const Vec3 v = p - proxy.point;
  const double a = std::atan2(v.dot(proxy.axis.cross(proxy.across)), v.dot(proxy.across));
  return a < 0 ? a + kTurn : a;
}

double rest_of_turns(double angle) {
  const double rest = angle < kTurn ? angle : angle < 2 * kTurn ? angle - kTurn : angle - 2 * kTurn;
  return rest >= 0 && rest < kTurn ? rest : std::fmod(angle, kTurn);
}

double turned(double angle) {
  const double a = rest_of_turns(angle + std::numbers::pi);
  return (a < 0 ? a + kTurn : a) - std::numbers::pi;
}

}  // namespace isimp::curved
