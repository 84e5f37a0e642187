#include "complex/flat_fit.h"

#include <cmath>

#include "isimp/core/symmetric.h"

namespace isimp::meshing {
namespace {

/// rounding: share of the largest eigenvalue. If both smaller ones are below it, the spread is a line, which fixes no plane.
constexpr double kLine = 1e-4;

}  // namespace

/// A symmetric matrix, its trace 1.
struct Fit::Spread {
  double xx, xy, xz, yy, yz, zz;

  [[nodiscard]] Vec3 times(const Vec3& n) const {
    return {xx * n[0] + xy * n[1] + xz * n[2], xy * n[0] + yy * n[1] + yz * n[2], xz * n[0] + yz * n[1] + zz * n[2]};
  }
  /// The sum of the products of two eigenvalues each.
  [[nodiscard]] double minors() const { return xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz; }
  /// The adjugate of this less a multiple of one, times n.
  [[nodiscard]] Vec3 adjugate_times(double less, const Vec3& n) const {
    const double a = xx - less, b = yy - less, c = zz - less;
    return Spread{b * c - yz * yz, xz * yz - xy * c, xy * yz - b * xz,
                  a * c - xz * xz, xy * xz - a * yz, a * b - xy * xy}
        .times(n);
  }
};

/// Turns the normal, which is near the direction of the smallest eigenvalue, into that direction, unless the spread is
/// a line. Each step takes an error to about its third power.
/// \return whether it could; else it may be another's direction
/// Source: the Rayleigh quotient iteration.
bool Fit::refine(const Spread& k) {
  Vec3& n = normal;
  constexpr double kSmall = 1e-6;  // rounding: squared, of a step: the one after it would change nothing that counts
  double turned = 1;
  for (int step = 0; step < 3 && turned > kSmall; ++step) {
    const Vec3 next = k.adjugate_times(n.dot(k.times(n)), n);
    const double length = next.norm();
    if (!(length > 1e-12)) return false;
    turned = (next / length - n).squaredNorm();
    n = next / length;
  }
  // The sum and the product of the other two eigenvalues.
  const double least = n.dot(k.times(n)), sum = 1 - least, product = k.minors() - least * sum;
  const bool is_least = 2 * least < sum && product - least * sum + least * least > 0;
  return turned <= kSmall && is_least && product >= kLine * sum * sum;
}

/// In the turns after the first the normal is near the one before.
bool Fit::find_normal(const Spread& k, const Vec3& of_chart) {
  if (!fixed || !refine(k)) {
    Eigen::Matrix3d full;
    full << k.xx, k.xy, k.xz, k.xy, k.yy, k.yz, k.xz, k.yz, k.zz;
    const auto [values, vectors] = direct_spectrum_of(full);
    if (values[1] < kLine * values[2]) return false;
    normal = vectors.col(0);
  }
  const double same = normal.dot(of_chart);
  if (same < 0) normal = -normal;
  return std::abs(same) >= 0.3;
}

void Fit::to(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Plane& plane, double bend) {
  if (plane.held) {
    normal = plane.normal;
    centre = plane.centre;
    return;
  }
  const double share = 1 / static_cast<double>(polygon.size());
  Vec3 middle = Vec3::Zero();
  for (const std::int32_t c : polygon) middle += position[c];
  middle *= share;
  // The spread of the corners, of the chart, and of their two middles about the middle of both.
  const double of_corner = bend * share, of_middles = bend / (1 + bend);
  const Vec3 between = plane.centre - middle;
  const auto& s = plane.spread;
  double xx = s(0, 0), xy = s(0, 1), xz = s(0, 2), yy = s(1, 1), yz = s(1, 2), zz = s(2, 2);
  const auto add = [&](const Vec3& d, double weight) {
    xx += weight * d[0] * d[0];
    xy += weight * d[0] * d[1];
    xz += weight * d[0] * d[2];
    yy += weight * d[1] * d[1];
    yz += weight * d[1] * d[2];
    zz += weight * d[2] * d[2];
  };
  for (const std::int32_t c : polygon) add(position[c] - middle, of_corner);
  add(between, of_middles);
  const double a = 1 / (xx + yy + zz);
  fixed = std::isfinite(a) && find_normal({a * xx, a * xy, a * xz, a * yy, a * yz, a * zz}, plane.normal);
  if (!fixed) normal = plane.normal;
  centre = (bend * middle + plane.centre) / (1 + bend);
}

}  // namespace isimp::meshing
