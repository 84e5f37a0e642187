#pragma once

#include <vector>

#include "region_planes.h"

namespace isimp::regular {

/// The upward direction and azimuths about it. A frame is an azimuth with the directions square to it.
class Compass {
 public:
  /// \param up  of length 1, or zero: there is none, and only has_up may be called
  explicit Compass(const Vec3& up);

  [[nodiscard]] bool has_up() const { return z_.squaredNorm() > 0; }
  [[nodiscard]] const Vec3& up() const { return z_; }
  [[nodiscard]] double azimuth(const Vec3& n) const;
  [[nodiscard]] Vec3 toward(double azimuth) const;
  /// The level direction nearest to another one.
  [[nodiscard]] Vec3 levelled(const Vec3& n) const;
  /// The direction of a frame nearest to an azimuth.
  static double nearest(double frame, double azimuth);

  /// The frame with the votes of most area.
  /// \param angle  twice the largest angle of planes that belong to it, radians
  [[nodiscard]] double vote(const std::vector<const RegionPlane*>& some, double angle) const;
  /// The frame, near a first one, that planes along it fit best.
  [[nodiscard]] double fitted(const std::vector<const RegionPlane*>& some, double first) const;

 private:
  Vec3 x_ = Vec3::Zero(), y_ = Vec3::Zero(), z_;
};

}  // namespace isimp::regular
