// Where the profile of a revolution passes from one simple surface to another.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/fit.h"
#include "isimp/core/symmetric.h"

namespace isimp::curved {
namespace {

/// Sums over corners of a profile, from which lines and circles are fitted.
class ProfileSums {
 public:
  explicit ProfileSums(const CurvedSurface& surface) : s_(surface) {}

  /// The least sum of squared distances of corners from a line, the profile of a cylinder or a cone, or from a circle
  /// about a point of the axis, that of a sphere.
  [[nodiscard]] double misfit(std::size_t first, std::size_t last) const {
    return std::min(of_line(first, last), of_circle(first, last));
  }

 private:
  [[nodiscard]] double of_line(std::size_t first, std::size_t last) const {
    const auto n = static_cast<double>(last - first);
    Vec2 middle = Vec2::Zero();
    for (std::size_t i = first; i < last; ++i) middle += corner(s_, i) / n;
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (std::size_t i = first; i < last; ++i) {
      const Vec2 v = corner(s_, i) - middle;
      spread += v * v.transpose();
    }
    return std::max(0.0, spectrum_of(spread).values[0]);
  }

  /// |p|^2 = 2 c z + k for the corners of a circle about (0, c), which is linear.
  [[nodiscard]] double of_circle(std::size_t first, std::size_t last) const {
    const auto n = static_cast<double>(last - first);
    double z = 0, q = 0, zz = 0, zq = 0;
    for (std::size_t i = first; i < last; ++i) {
      const Vec2 p = corner(s_, i);
      z += p.y() / n;
      q += p.squaredNorm() / n;
      zz += p.y() * p.y() / n;
      zq += p.y() * p.squaredNorm() / n;
    }
    const double spread = zz - z * z;
    if (!(spread > 0)) return std::numeric_limits<double>::infinity();
    const double c = (zq - z * q) / spread / 2, radius = std::sqrt(std::max(0.0, q - 2 * c * z + c * c));
    double sum = 0;
    for (std::size_t i = first; i < last; ++i) sum += std::pow((corner(s_, i) - Vec2(0, c)).norm() - radius, 2);
    return sum;
  }

  const CurvedSurface& s_;
};

}  // namespace

std::optional<double> profile_break(const CurvedSurface& surface) {
  const std::size_t n = corners(surface);
  if (surface.closed) return std::nullopt;
  const ProfileSums sums(surface);
  // The first and the last corner are extrapolated.
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t at = 2; at + 1 < n; ++at) {
    const double both = sums.misfit(1, at) + sums.misfit(at, n - 1);
    if (both >= least) continue;
    least = both;
    best = at;
  }
  if (best == 0) return std::nullopt;
  double length = 0;
  for (std::size_t i = 1; i < best; ++i) length += (corner(surface, i) - corner(surface, i - 1)).norm();
  return length + (corner(surface, best) - corner(surface, best - 1)).norm() / 2;
}

}  // namespace isimp::curved
