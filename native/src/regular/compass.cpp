#include "compass.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "isimp/core/symmetric.h"

namespace isimp::regular {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;  // unit
// tuned regular
constexpr double kVote = 1.5 * std::numbers::pi / 180;  ///< width of a vote for a frame

double azimuth_difference(double a, double b) {
  const double d = std::fmod(a - b + kQuarter / 2, kQuarter);
  return (d < 0 ? d + kQuarter : d) - kQuarter / 2;
}

}  // namespace

Compass::Compass(const Vec3& up) : z_(up) {
  if (!has_up()) return;
  const Vec3 axis = Vec3::Unit(std::abs(z_.x()) < 0.9 ? 0 : 1);
  x_ = (axis - z_.dot(axis) * z_).normalized();
  y_ = z_.cross(x_);
}

double Compass::azimuth(const Vec3& n) const { return std::atan2(n.dot(y_), n.dot(x_)); }

Vec3 Compass::toward(double azimuth) const { return std::cos(azimuth) * x_ + std::sin(azimuth) * y_; }

Vec3 Compass::levelled(const Vec3& n) const {
  const Vec3 flat = n - n.dot(z_) * z_;
  return flat.norm() > 0 ? Vec3(flat.normalized()) : z_;
}

double Compass::nearest(double frame, double azimuth) {
  return frame + std::round((azimuth - frame) / kQuarter) * kQuarter;
}

double Compass::vote(const std::vector<const RegionPlane*>& some, double angle) const {
  double best = 0, most = -1;
  for (int k = 0; k < 360; ++k) {
    const double here = kQuarter * k / 360;
    double sum = 0;
    for (const RegionPlane* r : some) {
      const double d = azimuth_difference(azimuth(r->normal), here) / kVote;
      sum += r->scan.area * std::exp(-d * d / 2);
    }
    if (sum <= most) continue;
    most = sum;
    best = here;
  }
  for (int k = 0; k < 10; ++k) {
    double sum = 0, area = 0;
    for (const RegionPlane* r : some) {
      const double d = azimuth_difference(azimuth(r->normal), best);
      if (std::abs(d) > angle / 2) continue;
      // The cost of turning the region: the directions of large walls are certain.
      const Vec3 side = z_.cross(levelled(r->normal));
      const double weight = r->scan.area * side.dot(r->scan.spread * side);
      sum += weight * d;
      area += weight;
    }
    if (area > 0) best += sum / area;
  }
  return best;
}

double Compass::fitted(const std::vector<const RegionPlane*>& some, double first) const {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const RegionPlane* r : some) {
    const double to = nearest(first, azimuth(r->normal)) - first;
    Eigen::Matrix<double, 3, 2> axes;  // turned so that the region's direction is that of the frame
    axes << std::cos(to) * x_ + std::sin(to) * y_, std::cos(to) * y_ - std::sin(to) * x_;
    sum += r->scan.area * axes.transpose() * r->scan.spread * axes;
  }
  const Eigen::Vector2d n = spectrum_of(sum).vectors.col(0);
  return nearest(std::atan2(n.y(), n.x()), first);
}

}  // namespace isimp::regular
